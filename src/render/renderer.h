// Renderers of a radiance field and their options. No Vulkan type here.
#pragma once

#include "core/words.h"
#include "field/radiance_field.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "gpu/device_options.h"
#include "image/depth_map.h"
#include "render/device_pace.h"
#include "render/integral.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <numbers>
#include <optional>
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

// The optical depth at which half of the light is lost.
inline constexpr double kHalfLightDepth = std::numbers::ln2;

// What a renderer counted since it was made.
struct RenderCounts {
  uint64_t rays = 0;
  // Rays that ended neither at the stop depth nor where the mesh ends; anything but 0 is a bug.
  // Lists and projected tets lose rays whose tets do not join face to face from begin to end, and
  // count them only if RendererOptions::count_steps is set.
  uint64_t lost_rays = 0;
  // Addends too large for the fixed-point sums of RendererOptions::deterministic, clamped there.
  uint64_t clamped_addends = 0;
  uint64_t device_bytes = 0;  // most that buffers took at one time; the reference has none
  // Counted for pictures, not for training, if RendererOptions::count_steps is set; otherwise 0.
  uint64_t hit_rays = 0;  // passed a tet
  uint64_t steps = 0;     // tets passed
};

struct KernelTime {
  std::string name;
  uint64_t calls = 0;
  double seconds = 0;
};

struct KernelReport {
  bool has_timestamps = false;  // asked for, and available on the device
  std::vector<KernelTime> kernels;
  uint64_t untimed_calls = 0;
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual void SetField(const RadianceField& field) = 0;
  // Averages samples x samples rays per pixel, on a regular grid.
  virtual RenderedImage Render(const RenderView& view, int samples) = 0;
  // The depth that the ray through each pixel's centre has when it has passed this optical depth;
  // for kHalfLightDepth a place on its way, unlike the mean depth. kNoDepth where the ray ends
  // before. The value of density is linear inside a tet, whatever the integral. The Vulkan
  // renderers march for it.
  virtual DepthMap RenderDepth(const RenderView& view, double optical_depth) = 0;
  virtual RenderCounts counts() const = 0;
  virtual nlohmann::json DescribeDevice() const = 0;
  // Since the renderer was made, of work that has been waited for.
  virtual KernelReport KernelTimes() const { return {}; }
};

// How a renderer finds the tets that a ray passes.
enum class RendererKind {
  kMarch,       // from tet to tet through neighbour links
  kPpll,        // rasterised faces in per-pixel linked lists, sorted
  kProjection,  // projected tets in sorted order
  kReference,   // cuts every tet near the ray, on the CPU: slow, and does not use Vulkan
};
template <>
inline constexpr auto kWords<RendererKind> =
    std::to_array<Word<RendererKind>>({{RendererKind::kMarch, "march"},
                                       {RendererKind::kPpll, "ppll"},
                                       {RendererKind::kProjection, "projection"},
                                       {RendererKind::kReference, "reference"}});

// The precision of kReference; the others compute in float.
enum class Precision { kDouble, kFloat };
template <>
inline constexpr auto kWords<Precision> =
    std::to_array<Word<Precision>>({{Precision::kDouble, "double"}, {Precision::kFloat, "float"}});

// The order in which projected tets are composited.
enum class VisibilityOrder {
  kExact,     // by the power of the camera if the mesh is Delaunay, otherwise by what covers what
  kCentroid,  // by the depth of the tets' centroids: approximate, needs no neighbours
};
template <>
inline constexpr auto kWords<VisibilityOrder> = std::to_array<Word<VisibilityOrder>>(
    {{VisibilityOrder::kExact, "exact"}, {VisibilityOrder::kCentroid, "centroid"}});

// How lists of fragments are sorted.
enum class FragmentSort {
  kAuto,   // shell sort, heap sort for long lists
  kShell,  // Ciura's gaps; an insertion sort for short lists
  kHeap,   // the article's
};
template <>
inline constexpr auto kWords<FragmentSort> =
    std::to_array<Word<FragmentSort>>({{FragmentSort::kAuto, "auto"},
                                       {FragmentSort::kShell, "shell"},
                                       {FragmentSort::kHeap, "heap"}});

struct RendererOptions {
  RendererKind kind = RendererKind::kMarch;
  VisibilityOrder order = VisibilityOrder::kExact;  // for projection
  Precision precision = Precision::kDouble;         // for the reference
  DeviceOptions device;
  IntegralOptions integral;
  // A ray ends behind the tet in which its transmittance falls to this; 0: never. The rule is the
  // same forward and backward.
  float stop_transmittance = 1e-3f;
  uint32_t max_steps = 1u << 16;  // tets on one ray
  // Of the tets of a field. A mesh with inverted tets shows parts of space twice or not at all: the
  // march leaves each tet by the face that it is the least wrong to leave by, takes the way there
  // as 0 where it leads backwards, and counts a ray as lost that circles for max_steps tets; lists
  // and projected tets sort what they are given; the reference skips what it cannot cut.
  Orientations orientations = Orientations::kPositive;
  bool count_steps = false;  // counts RenderCounts::hit_rays and steps; a little slower
  // Sums gradients and scores in 64-bit fixed point: the same bits for any number of threads and
  // any order of the rays. Requires a device with 64-bit integer atomics.
  bool deterministic = false;
  // Memory for lists of fragments on the device [bytes]. To fit, images are tiled, or composited
  // one stretch of tets at a time.
  uint64_t fragment_memory = 512ull << 20;
  FragmentSort fragment_sort = FragmentSort::kAuto;
  std::optional<DevicePace> pace;  // for tests: that of another device

  // Throws UsageError if an option is set that this renderer does not have.
  void Check() const;
  // Accepts inverted tets. Rays that circle among them end after some thousand tets, many times
  // more than a ray passes in a mesh of millions.
  void AcceptInvertedTets();
};

// True if RenderCounts::lost_rays is known: lists and projected tets are checked if steps are
// counted.
inline bool ChecksRays(const RendererOptions& options) {
  return options.kind == RendererKind::kMarch || options.kind == RendererKind::kReference ||
         options.count_steps;
}

}  // namespace tetrec
