// Renderers of a radiance field, forward and backward. No Vulkan type here.
#pragma once

#include "core/words.h"
#include "field/radiance_field.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "gpu/device_options.h"
#include "render/integral.h"
#include "render/loss.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct RenderView {
  Camera camera;
  Rigid3 cam_from_world;
};

// Without background: picture = color + transmittance x background.
struct RenderedImage {
  int width = 0, height = 0;
  std::vector<glm::vec3> color_srgb;  // (height x width), row by row
  std::vector<float> transmittance;   // (height x width)
};

// What a renderer counted since it was made.
struct RenderCounts {
  uint64_t rays = 0;
  // Ended neither at the stop depth nor where the mesh ends; 0 or a bug. Of lists and projected
  // tets those whose tets do not join face to face from where they begin to where they end: told
  // only where RendererOptions::count_steps is set.
  uint64_t lost_rays = 0;
  // Of RendererOptions::deterministic: addends too large for the fixed-point sums, clamped there.
  uint64_t clamped_addends = 0;
  uint64_t device_bytes = 0;  // most that buffers took at one time; the reference has none
  // Of Render and MarchBlocks where RendererOptions::count_steps is set, else 0.
  uint64_t hit_rays = 0;  // passed a tet
  uint64_t steps = 0;     // tets passed
};

struct KernelTime {
  std::string name;
  uint64_t calls = 0;
  double seconds = 0;
};

struct KernelReport {
  bool has_timestamps = false;  // asked for, and the device has them
  std::vector<KernelTime> kernels;
  uint64_t untimed_calls = 0;
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual void SetField(const RadianceField& field) = 0;
  // samples x samples rays a pixel on a regular grid, averaged.
  virtual RenderedImage Render(const RenderView& view, int samples) = 0;
  virtual RenderCounts counts() const = 0;
  virtual nlohmann::json DescribeDevice() const = 0;
  // Since the renderer was made, of what has been waited for.
  virtual KernelReport KernelTimes() const { return {}; }
};

// dL/d(colour, density) of every row of the field, dL/dposition of every vertex.
struct FieldGradient {
  std::vector<glm::vec3> color_srgb;
  std::vector<float> density;
  // Where positions are asked for, else empty. World frame. A face that a ray meets edge-on, its
  // angle lost in rounding, gives nothing there: the true gradient grows without bound.
  std::vector<glm::vec3> position;
  // As AbsGS (Ye et al. 2024): the sum, over the rays' passages of the tets around the vertex, of
  // the length of the passage's own dL/dposition across the ray. Across, because that is what a
  // move changes in the picture, and because gradients along the rays grow with how flat the faces
  // lie to them. Opposite wishes of different rays add up here and cancel in `position`.
  std::vector<float> absolute_position;
};

// Which gradients to compute; those by positions make the backward pass slower.
enum class GradientParts { kColorDensity, kColorDensityPosition };

// A pixel of a picture in [0, 1], colour premultiplied by alpha.
struct TargetImage {
  int width = 0, height = 0;
  std::vector<uint32_t> rgba8;  // r in the lowest byte; or kNotJudgedTarget
};
// White of alpha 0, which no premultiplied colour is: no residual, no gradient
// (shared/loss.glsl.h).
inline constexpr uint32_t kNotJudgedTarget = 0x00FFFFFF;

// 4 x 2 rays through neighbouring pixels of view `view`, the first at (x, y).
struct RayBlock {
  uint32_t view, x, y, padding = 0;
};
constexpr int kRayBlockWidth = 4, kRayBlockHeight = 2, kRaysPerBlock = 8;

// Parameters of the field and the state of Adam, one row a vertex (a tet, where cells have the
// attributes): rgb and the logarithm of density.
struct VertexState {
  std::vector<glm::vec4> parameters, first_moment, second_moment;
  FieldStorage storage = FieldStorage::kVertex;
};

// Parameters of a field, row by row. Density 0, which has no logarithm, becomes e^-80.
std::vector<glm::vec4> ParametersOf(const RadianceField& field);

struct AdamOptions {
  float beta1 = 0.9f, beta2 = 0.99f;
  float epsilon = 1e-12f;  // gradients of a mean over many rays are tiny
  float color_rate = 0.02f, density_rate = 0.2f;
  float max_density = 1e6f;  // [1 / world unit]
  // Pull of seen vertices towards empty, as a share of Adam's largest step.
  float density_decay = 0.0f;
};

// Blocks a row and rows of blocks of a tile: a rectangle of one view, row of blocks by row.
struct TileShape {
  uint32_t columns = 0, rows = 0;
};

struct TrainingStep {
  std::span<const RayBlock> blocks;
  LossKind loss = LossKind::kL2;
  float dssim_weight = 0.0f;  // LossOptions::dssim
  // Where there is a dssim_weight: `blocks` is a row of such tiles, each at least 11 x 11 pixels
  // and inside its picture.
  TileShape tiles;
  glm::vec3 background_srgb{0.0f};  // stands behind field and target
  float jitter_px = 0.0f;
  uint32_t seed = 0;
  uint32_t adam_step = 1;  // counts from 1
  AdamOptions adam;
};

struct StepResult {
  double loss = 0;           // mean over rays and channels
  double squared_error = 0;  // mean over rays and channels
};

// A renderer that learns. The field lives on the device between SetVertexState and ReadVertexState.
class TrainingRenderer : public Renderer {
 public:
  // Views and what they should show; sizes must agree.
  virtual void SetTargets(std::span<const RenderView> views,
                          std::span<const TargetImage> targets) = 0;
  // Another storage than the one before takes some time: kernels are made for one.
  virtual void SetVertexState(const TetMesh& mesh, const VertexState& state) = 0;
  virtual VertexState ReadVertexState() = 0;
  // Whether every batch of blocks must be one tile.
  virtual bool NeedsTiles() const = 0;
  // Forward, loss, backward, Adam; returns before the device is done. The result is that of the
  // step before last waits for (one step late), zero for the first.
  virtual StepResult Step(const TrainingStep& step) = 0;
  // Adds the blocks' errors to the scores of ReadScores; ClearScores first.
  virtual void ClearScores() = 0;
  // At most kMostScoredRays rays between ClearScores and ReadScores.
  virtual StepResult AddScores(const TrainingStep& step) = 0;
  // (T) sum over rays of the squared residual times the tet's share of the ray's opacity.
  virtual std::vector<float> ReadScores() = 0;
  // dL/dfield for dL/d(rgb, transmittance) of each pixel of a view rendered with one ray a pixel.
  virtual FieldGradient Backpropagate(const RenderView& view,
                                      std::span<const glm::vec4> pixel_gradient,
                                      GradientParts parts = GradientParts::kColorDensity) = 0;
  // Colour before the background and optical depth of every ray of `blocks`, all of `view` (their
  // `view` is 0), one ray a pixel; zero outside the picture.
  virtual std::vector<glm::vec4> MarchBlocks(const RenderView& view,
                                             std::span<const RayBlock> blocks) = 0;
  // What the Vulkan validation layer said since the renderer was made; empty means clean or off.
  virtual std::vector<std::string> ValidationMessages() const = 0;
};

// How a renderer finds the tets that a ray passes.
enum class RendererKind {
  kMarch,       // from tet to tet through neighbour links
  kPpll,        // rasterised faces in per-pixel linked lists, sorted
  kProjection,  // projected tets in sorted order
  kReference,   // every tet near the ray is cut, on the CPU: slow, and touches no Vulkan
};
template <>
inline constexpr auto kWords<RendererKind> =
    std::to_array<Word<RendererKind>>({{RendererKind::kMarch, "march"},
                                       {RendererKind::kPpll, "ppll"},
                                       {RendererKind::kProjection, "projection"},
                                       {RendererKind::kReference, "reference"}});

// Of kReference; the others compute in float.
enum class Precision { kDouble, kFloat };
template <>
inline constexpr auto kWords<Precision> =
    std::to_array<Word<Precision>>({{Precision::kDouble, "double"}, {Precision::kFloat, "float"}});

// In which order projected tets are composited.
enum class VisibilityOrder {
  kExact,     // by the power of the camera where the mesh is Delaunay, else by what covers what
  kCentroid,  // by the depth of the tets' centroids: approximate, needs no neighbours
};
template <>
inline constexpr auto kWords<VisibilityOrder> = std::to_array<Word<VisibilityOrder>>(
    {{VisibilityOrder::kExact, "exact"}, {VisibilityOrder::kCentroid, "centroid"}});

// How lists of fragments are sorted.
enum class FragmentSort {
  kAuto,   // shell sort, heap sort for long lists
  kShell,  // gaps of Ciura; an insertion sort where lists are short
  kHeap,   // the article's
};
template <>
inline constexpr auto kWords<FragmentSort> =
    std::to_array<Word<FragmentSort>>({{FragmentSort::kAuto, "auto"},
                                       {FragmentSort::kShell, "shell"},
                                       {FragmentSort::kHeap, "heap"}});

struct RendererOptions {
  RendererKind kind = RendererKind::kMarch;
  VisibilityOrder order = VisibilityOrder::kExact;  // of projection
  Precision precision = Precision::kDouble;         // of the reference
  DeviceOptions device;
  IntegralOptions integral;
  // A ray ends behind the tet in which its transmittance falls to this; 0: never. The same rule
  // forward and backward.
  float stop_transmittance = 1e-3f;
  uint32_t max_steps = 1u << 16;  // tets on one ray
  bool count_steps = false;       // fill RenderCounts' last ones; a little slower
  // Gradients and scores are summed in 64-bit fixed point: the same bits whatever the number of
  // threads and the order of the rays. Needs a device with 64-bit integer atomics.
  bool deterministic = false;
  // What lists of fragments may take on the device [bytes]; pictures are tiled, or composited a
  // stretch of tets at a time, to fit.
  uint64_t fragment_memory = 512ull << 20;
  FragmentSort fragment_sort = FragmentSort::kAuto;
};

// Whether RenderCounts::lost_rays is known: lists and projected tets are checked where steps are
// counted.
inline bool ChecksRays(const RendererOptions& options) {
  return options.kind == RendererKind::kMarch || options.kind == RendererKind::kReference ||
         options.count_steps;
}

// Throws EnvironmentError where there is no such device.
std::unique_ptr<TrainingRenderer> CreateRenderer(const RendererOptions& options);

}  // namespace tetrec
