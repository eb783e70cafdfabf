// A renderer that learns: steps of training whole and in parts, and scores. No Vulkan type here.
#pragma once

#include "field/field_state.h"
#include "mesh/mesh_edges.h"
#include "render/exposure.h"
#include "render/loss.h"
#include "render/renderer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tetrec {

// A picture's pixels in [0, 1], colour premultiplied by alpha.
struct TargetImage {
  int width = 0, height = 0;
  std::vector<uint32_t> rgba8;  // r in the lowest byte; or kNotJudgedTarget
};
// White of alpha 0, which is not a premultiplied colour: no residual, no gradient
// (shared/loss.glsl.h).
inline constexpr uint32_t kNotJudgedTarget = 0x00FFFFFF;

// 4 x 2 neighbouring rays of view `view`, the first at (x, y). Renderers set `slot`,
// the view's place among those of the batch.
struct RayBlock {
  uint32_t view, x, y, slot = 0;
};
constexpr int kRayBlockWidth = 4, kRayBlockHeight = 2, kRaysPerBlock = 8;

// The largest TrainingBatch::samples.
constexpr int kMostTrainingSamples = 2;

// Blocks per row and rows of blocks of a tile: a rectangle of one view, row of blocks by row.
struct TileShape {
  uint32_t columns = 0, rows = 0;
};

// Which gradients to compute; those by positions make the backward pass slower.
enum class GradientParts {
  kColorDensity,
  kMotion,  // by positions, too; GradientSums::absolute_position may stay 0
  kColorDensityPosition,
};

inline bool HasPositions(GradientParts parts) { return parts != GradientParts::kColorDensity; }

// Rays and what they are compared by.
struct TrainingBatch {
  std::span<const RayBlock> blocks;
  LossKind loss = LossKind::kL2;
  float dssim_weight = 0.0f;  // LossOptions::dssim
  // With a dssim_weight `blocks` is a row of such tiles, each at least 11 x 11 pixels and inside
  // its picture.
  TileShape tiles;
  glm::vec3 background_srgb{0.0f};  // behind field and target
  // Weight of the opacity, whose target is alpha, in the pixel loss; that of each channel is 1.
  // Scores do not contain it.
  float alpha_weight = 0.0f;
  // samples x samples rays per pixel, 1 or 2; with 2, blocks are of 2 x 1 pixels, their x and y
  // count rays and are even, and what a pixel is compared with is the mean of its rays. Only 1 with
  // a dssim_weight, and for scores.
  int samples = 1;
  float jitter_px = 0.0f;  // of a ray inside its share of the pixel, as a part of that
  uint32_t seed = 0;
  // The loss is a mean over this many rays: those of all batches whose gradients are summed for
  // one update. 0: those of this batch.
  uint64_t update_rays = 0;
  // Also sums what the views' exposures are fitted from, for AddExposureSums.
  bool sums_exposures = false;
  // What Step computes; gradients by positions are summed for TakePositionGradients.
  GradientParts parts = GradientParts::kColorDensity;

  uint64_t rays() const { return blocks.size() * kRaysPerBlock; }
  uint64_t rays_of_mean() const { return update_rays > 0 ? update_rays : rays(); }
};

// One update by Adam (Kingma and Ba 2015); attributes behind density are updated without the first
// moment (shared/adam.glsl.h).
struct AdamUpdate {
  uint32_t step = 1;  // counts from 1
  float beta1 = 0.9f, beta2 = 0.99f;
  float epsilon = 1e-12f;  // gradients of a mean over many rays are tiny
  double color_rate = 0.02, density_rate = 0.2, harmonics_rate = 0.015;  // by RateClass
  double max_density = 1e5;  // bound of density, and of attributes of kExp [1 / world unit]
  // Pull of seen rows towards empty (RowRates), as a share of Adam's largest step.
  double density_decay = 0.0;
  // Share by which the coefficients of seen rows decay in a step, per unit of their learning rate.
  double harmonics_decay = 0.0;
};

// How a row differs from others in its updates.
struct RowRates {
  float share = 1.0f;  // of the learning rates, in [0, 1]; a row of 0 stays
  // Density from which on it does not decay [1 / world unit].
  float kept_density = std::numeric_limits<float>::infinity();
  // Density below which it does not fall [1 / world unit].
  float least_density = -std::numeric_limits<float>::infinity();
};

struct StepResult {
  // Mean over the batch's rays of a third of the sum over the channels and opacity.
  double loss = 0;
  double squared_error = 0;  // mean over the batch's rays and channels
};

// Gradients by positions are summed over no more batches than this: fixed-point sums have room for
// them.
inline constexpr uint64_t kMostSummedBatches = 16;

// Sums over batches since they were last taken, or used by an update.
struct GradientSums {
  std::vector<double> values;  // dL/dvalue (not parameter), rows x layout.Components()
  // From backward passes with positions, otherwise empty. World frame, per vertex. A face that a
  // ray meets edge-on, its angle lost in rounding, adds nothing: the true gradient grows without
  // bound. View-dependent colours count as if they stayed when the vertex moves: the turn of the
  // direction from the camera is left out.
  std::vector<glm::dvec3> position;
  // As AbsGS (Ye et al. 2024): the sum, over the rays' passages of the tets around the vertex, of
  // the length of the passage's own dL/dposition across the ray. Across, because that is what a
  // move changes in the picture, and because gradients along the rays grow with how flat the faces
  // lie to them. Opposite gradients of different rays add up here and cancel in `position`.
  std::vector<double> absolute_position;
};

// A ray's error in AddScores: the sum over the channels of the residual's squares or absolute
// values. The residual is that of what the view shows.
enum class ScoreKind { kSquaredResidual, kAbsoluteResidual };

// What the rays of AddScores say of each tet.
struct TetScores {
  std::vector<float> errors;  // rays' errors times the tet's shares of their opacity
  // The shares themselves, where they are at least kLeastVisibleShare: 0 for tets not seen.
  std::vector<float> light;
};

// What the rays say of a vertex that would halve an edge, by its hat function
// (shared/edge_hat.glsl.h) and half the squared residual of what the view shows, summed over rays
// and channels. Curvatures are Gauss-Newton's, sums of squared slopes of what a ray shows, for each
// passage of a tet on its own; by colour, those of one channel.
struct EdgeSums {
  glm::dvec3 color{0.0};  // dL/dcolour
  double density = 0;     // dL/ddensity [world units]
  double color_curvature = 0, density_curvature = 0;
};

// The field is on the device between SetState and ReadState.
class TrainingRenderer : public Renderer {
 public:
  // Views and what they should show; sizes must agree.
  virtual void SetTargets(std::span<const RenderView> views,
                          std::span<const TargetImage> targets) = 0;
  // How the training views show the field, one per view; neutral after SetTargets of another number
  // of views, which otherwise leaves exposures and their sums as they are. Pictures of Render are
  // of the field itself.
  virtual void SetExposures(std::span<const ViewExposure> exposures) = 0;
  // Adds to `sums`, one per view, those of the batches with sums_exposures since the last call,
  // block by block in the order in which they were given: the result is the same, bit by bit,
  // however often this is called in between. Waits for the steps in flight.
  virtual void AddExposureSums(std::span<ExposureSums> sums) = 0;
  // Takes longer if the layout is not that of the field before: kernels are made for one.
  virtual void SetState(TetMesh mesh, const FieldState& state) = 0;
  virtual FieldState ReadState() = 0;
  // The mesh of the field.
  virtual const TetMesh& mesh() const = 0;
  // Gives the mesh away and frees the field, so that it takes no memory while another is made.
  // The renderer has no field until the next SetState.
  virtual TetMesh TakeMesh() = 0;
  virtual DevicePace Pace() const = 0;
  // Whether every batch that is learned from must be one tile. Forward alone takes any blocks.
  virtual bool NeedsTiles() const = 0;

  // Forward, loss, backward, update in one go; returns before the device is done. The result is
  // that of the step before last (which it waits for), zero for the first.
  virtual StepResult Step(const TrainingBatch& batch, const AdamUpdate& update) = 0;

  // The parts of a step, each done when it returns. Forward and Backward of any number of batches
  // that agree in rays_of_mean, loss and dssim_weight, then Update, make what one Step over all
  // their blocks makes.

  // Renders a batch and compares it with its targets.
  virtual StepResult Forward(const TrainingBatch& batch) = 0;
  // Adds the gradients of the batch of Forward to the sums. Nothing is rendered in between.
  virtual void Backward(GradientParts parts) = 0;
  // Reads the sums and sets them to zero.
  virtual GradientSums TakeGradients() = 0;
  // Reads the sums of gradients by positions, and only those, and sets them to zero.
  virtual GradientSums TakePositionGradients() = 0;
  // Moves the vertices of the mesh. Its tets stay positively oriented, its boundary where it is;
  // parameters, moments and sums stay.
  virtual void MoveVertices(std::span<const glm::vec3> positions) = 0;
  // Adds given sums, those of another machine or of a regulariser.
  virtual void AddGradients(const GradientSums& sums) = 0;
  // Adam by the sums of dL/dvalue, which are zero then.
  virtual void Update(const AdamUpdate& update) = 0;
  // Replaces all parameters by what another optimiser made of the gradients; moments stay.
  virtual void WriteParameters(std::span<const float> parameters) = 0;

  // One per row. All are RowRates() after SetState.
  virtual void SetRowRates(std::span<const RowRates> rates) = 0;

  // Adds the blocks' errors to the scores of ReadScores; ClearScores first. The batch's loss does
  // not matter; its result comes as that of Step does.
  virtual void ClearScores() = 0;
  // At most kMostScoredRays rays between ClearScores and ReadScores.
  virtual StepResult AddScores(const TrainingBatch& batch, ScoreKind kind) = 0;
  virtual TetScores ReadScores() = 0;

  // The same for edges, those of the mesh, of a field with values at vertices. Passages of tets in
  // which a ray loses less than kLeastScoredShare add nothing.
  virtual void ClearEdgeSums(const MeshEdges& edges) = 0;
  virtual StepResult AddEdgeSums(const TrainingBatch& batch) = 0;
  // Per edge; frees what ClearEdgeSums made.
  virtual std::vector<EdgeSums> TakeEdgeSums() = 0;
};

}  // namespace tetrec
