// The reference renderer behind the interface of the others: images, gradients and training steps
// on the CPU.
#include "render/reference/reference_renderer.h"

#include "core/error.h"
#include "render/field_checks.h"
#include "render/reference/batch_loss.h"
#include "render/reference/edge_shares.h"
#include "render/reference/error_shares.h"
#include "render/reference/gradient_sums.h"
#include "render/reference/ray_caster.h"
#include "render/reference/row_update.h"
#include "render/reference/row_values.h"
#include "render/seen_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

namespace tetrec {
namespace {

// The memory of a field: per tet the mesh, its boxes and scores; per component of a row the
// parameter, moments and sum of gradients; per row what it has besides.
constexpr uint64_t kBytesPerTet = 100, kBytesPerComponent = 40, kBytesPerRow = 40;

template <class Real>
class ReferenceRenderer final : public ProbedRenderer {
 public:
  explicit ReferenceRenderer(const RendererOptions& options)
      : pace_(options.pace.value_or(DevicePace())),
        orientations_(options.orientations),
        caster_(options) {}

  // Keeps the field's own densities instead of converting them to logarithms and back.
  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetState(field.mesh, StateOf(field));
    field_ = field;
  }

  void SetState(TetMesh mesh, const FieldState& state) override {
    CheckRenderable(mesh, state, orientations_);
    const size_t rows = state.rows(), components = size_t(state.layout.Components());
    CheckMemory(
        mesh,
        kBytesPerTet * mesh.tets.size() + (kBytesPerRow + kBytesPerComponent * components) * rows,
        MeasureFreeHostMemory());
    state_ = state;
    field_ = MakeField(std::move(mesh), state.layout, std::vector<float>(rows * components));
    SpreadAll();
    row_rates_.assign(rows, {});
    boxes_ = MakeTetBoxes(field_.mesh);
    ClearScores();
    sums_ = ReferenceSums(field_);
    forward_.reset();
  }

  FieldState ReadState() override { return state_; }

  const TetMesh& mesh() const override { return field_.mesh; }

  TetMesh TakeMesh() override {
    TetMesh mesh = std::move(field_.mesh);
    field_ = {};
    boxes_ = {};
    forward_.reset();
    sums_ = {};
    return mesh;
  }

  void SetTargets(std::span<const RenderView> views,
                  std::span<const TargetImage> targets) override {
    TETREC_CHECK(views.size() == targets.size(), "one target per view");
    for (size_t i = 0; i < views.size(); ++i) {
      TETREC_CHECK(
          views[i].camera.width == targets[i].width && views[i].camera.height == targets[i].height,
          fmt::format("target {} and its camera differ in size", i));
    }
    targets_.views.assign(views.begin(), views.end());
    targets_.pictures.assign(targets.begin(), targets.end());
    if (targets_.exposures.size() == views.size()) return;
    targets_.exposures.assign(views.size(), {});
    block_sums_.clear();
  }

  void SetExposures(std::span<const ViewExposure> exposures) override {
    TETREC_CHECK(exposures.size() == targets_.views.size(), "one exposure per view");
    targets_.exposures.assign(exposures.begin(), exposures.end());
  }

  void AddExposureSums(std::span<ExposureSums> sums) override {
    AddBlockSums(block_sums_, sums);
    block_sums_.clear();
  }

  DevicePace Pace() const override { return pace_; }
  bool NeedsTiles() const override { return false; }

  StepResult Step(const TrainingBatch& batch, const AdamUpdate& update) override {
    const StepResult result = Forward(batch);
    Backward(batch.parts);
    Update(update);
    return OneStepLate(result);
  }

  StepResult Forward(const TrainingBatch& batch) override {
    forward_.emplace();
    forward_->blocks.assign(batch.blocks.begin(), batch.blocks.end());
    forward_->batch = batch;
    forward_->batch.blocks = forward_->blocks;
    const BatchRays rays = RaysOf(targets_.views, batch);
    std::vector<Vec4<Real>>& gradients = forward_->gradients;
    gradients.resize(rays.count());
    const std::vector<Vec4<Real>> shown = ShownPixels(rays, caster_.March(field_, boxes_, rays));
    const Real scale = Real(1) / Real(3 * batch.rays_of_mean());
    StepResult result = CompareWithTargets<Real>(targets_, rays, shown, batch, scale, gradients);
    ChainToRays<Real>(targets_, rays, batch, gradients);
    if (batch.sums_exposures) SumExposures<Real>(targets_, rays, shown, batch, block_sums_);
    if (batch.dssim_weight > 0) MixDssim<Real>(targets_, rays, shown, batch, gradients, result);
    return result;
  }

  void Backward(GradientParts parts) override {
    TETREC_CHECK(forward_, "Backward follows Forward");
    const BatchRays rays = RaysOf(targets_.views, forward_->batch);
    const bool with_positions = HasPositions(parts);
    for (const auto& [view, seen] : FieldsSeenBy(rays, field_)) {
      const bool is_of_all_rays = seen.get() == &field_;
      ReferenceGradient sum(field_);
      caster_.AddGradients(
          *seen, boxes_, rays.count(), [&](size_t i) { return RayOf<Real>(rays, i); },
          [&, view = view](size_t i) {
            return is_of_all_rays || rays.IndexOfView(i) == view ? forward_->gradients[i]
                                                                 : Vec4<Real>(Real(0));
          },
          with_positions, sum);
      sums_.Add(sum, field_, CenterOf(targets_.views[view]), with_positions);
    }
  }

  GradientSums TakeGradients() override { return sums_.Take(); }

  GradientSums TakePositionGradients() override { return sums_.TakePositions(); }

  void MoveVertices(std::span<const glm::vec3> positions) override {
    field_.mesh.positions.assign(positions.begin(), positions.end());
    boxes_ = MakeTetBoxes(field_.mesh);
    forward_.reset();
  }

  void AddGradients(const GradientSums& sums) override { sums_.Add(sums); }

  void Update(const AdamUpdate& update) override {
    const RowUpdate<Real> row_update(update, state_.layout);
    const std::vector<const Attribute*> attributes = state_.layout.ByComponent();
    std::vector<Real> by_parameter(attributes.size());
    for (size_t row = 0; row < state_.rows(); ++row) {
      for (size_t c = 0; c < attributes.size(); ++c) {
        const float parameter = state_.parameters[row * attributes.size() + c];
        by_parameter[c] = Real(sums_.At(row, c)) * SlopeOf(*attributes[c], Real(parameter));
      }
      row_update.Apply(state_, row, by_parameter, row_rates_[row]);
      SpreadRow<Real>(state_, row, field_);
    }
    sums_.ClearValues();
  }

  void SetRowRates(std::span<const RowRates> rates) override {
    CheckRowRates(rates, state_.rows());
    row_rates_.assign(rates.begin(), rates.end());
  }

  void WriteParameters(std::span<const float> parameters) override {
    CheckRows(parameters, state_.layout, state_.rows(), "parameters");
    state_.parameters.assign(parameters.begin(), parameters.end());
    SpreadAll();
  }

  void ClearScores() override {
    errors_.assign(field_.mesh.tets.size(), 0.0);
    light_.assign(field_.mesh.tets.size(), 0.0);
  }

  StepResult AddScores(const TrainingBatch& batch, ScoreKind kind) override {
    return WithResiduals(batch, [&](const BatchRays& rays, const auto& residuals, const auto&) {
      AddErrorShares<Real>(field_, boxes_, caster_.stop_depth(), rays, residuals, kind, errors_,
                           light_);
    });
  }

  TetScores ReadScores() override {
    return {{errors_.begin(), errors_.end()}, {light_.begin(), light_.end()}};
  }

  void ClearEdgeSums(const MeshEdges& edges) override {
    edges_ = edges;
    edge_sums_.assign(edges.ends.size(), {});
  }

  StepResult AddEdgeSums(const TrainingBatch& batch) override {
    return WithResiduals(
        batch, [&](const BatchRays& rays, const auto& residuals, const auto& shown) {
          AddEdgeShares<Real>(field_, boxes_, caster_.stop_depth(), rays, batch.background_srgb,
                              residuals, shown, edges_, edge_sums_);
        });
  }

  std::vector<EdgeSums> TakeEdgeSums() override {
    edges_ = {};
    return std::exchange(edge_sums_, {});
  }

  RenderedImage Render(const RenderView& view, int samples) override {
    return caster_.Render(FieldSeenFrom(field_, CenterOf(view)), boxes_, view, samples);
  }

  DepthMap RenderDepth(const RenderView& view, double optical_depth) override {
    return caster_.RenderDepth(field_, boxes_, view, optical_depth);
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    TETREC_CHECK(pixel_gradient.size() == size_t(view.camera.width) * size_t(view.camera.height),
                 "one gradient per pixel");
    const bool with_positions = HasPositions(parts);
    ReferenceGradient sum(field_);
    caster_.Backpropagate(FieldSeenFrom(field_, CenterOf(view)), boxes_, view, pixel_gradient,
                          with_positions, sum);
    FieldGradient result;
    result.color_srgb.assign(sum.color_srgb.begin(), sum.color_srgb.end());
    result.density.assign(sum.density.begin(), sum.density.end());
    if (with_positions) {
      result.position.assign(sum.position.begin(), sum.position.end());
      result.absolute_position.assign(sum.absolute_position.begin(), sum.absolute_position.end());
    }
    return result;
  }

  std::vector<glm::vec4> MarchBlocks(const RenderView& view,
                                     std::span<const RayBlock> blocks) override {
    const BatchRays batch{std::span(&view, 1), blocks};
    const std::vector<Vec4<Real>> rays = caster_.March(field_, boxes_, batch);
    return {rays.begin(), rays.end()};
  }

  RenderCounts counts() const override { return caster_.counts(); }

  nlohmann::json DescribeDevice() const override {
    return {{"name", std::is_same_v<Real, double> ? "CPU, double precision" : "CPU, float"},
            {"type", "software"},
            {"threads", std::max(1u, std::thread::hardware_concurrency())}};
  }

  std::vector<std::string> ValidationMessages() const override { return {}; }

 private:
  // What Backward needs of Forward.
  struct ForwardedBatch {
    std::vector<RayBlock> blocks;
    TrainingBatch batch;                // of these blocks
    std::vector<Vec4<Real>> gradients;  // dL/d(rgb, transmittance) of each ray
  };

  void SpreadAll() {
    for (size_t row = 0; row < state_.rows(); ++row) SpreadRow<Real>(state_, row, field_);
  }

  // Calls use(rays, residuals, shown) for a batch. A gradient scale of 1/2 makes the gradients of
  // L2 the residuals themselves.
  template <class Use>
  StepResult WithResiduals(const TrainingBatch& batch, const Use& use) {
    TETREC_CHECK(batch.samples == 1, "scores take one ray per pixel");
    const BatchRays rays = RaysOf(targets_.views, batch);
    TrainingBatch by_square = batch;
    by_square.loss = LossKind::kL2;
    by_square.alpha_weight = 0;
    std::vector<Vec4<Real>> residuals(rays.count());
    const std::vector<Vec4<Real>> shown = ShownPixels(rays, caster_.March(field_, boxes_, rays));
    const StepResult result =
        CompareWithTargets<Real>(targets_, rays, shown, by_square, Real(0.5), residuals);
    use(rays, residuals, shown);
    return OneStepLate(result);
  }

  // Like the other renderers, which have two batches in flight.
  StepResult OneStepLate(const StepResult& result) {
    current_ ^= 1;
    return std::exchange(results_[current_], result);
  }

  DevicePace pace_;
  Orientations orientations_;
  RayCaster<Real> caster_;
  RadianceField field_;  // the values of the parameters in state_
  TetBoxes boxes_;
  FieldState state_;
  std::vector<RowRates> row_rates_;
  ReferenceSums sums_;  // since the last update
  std::optional<ForwardedBatch> forward_;
  TrainingTargets targets_;
  std::vector<BlockExposureSums> block_sums_;  // since AddExposureSums
  std::vector<double> errors_, light_;         // of tets
  MeshEdges edges_;
  std::vector<EdgeSums> edge_sums_;
  std::array<StepResult, 2> results_;
  int current_ = 0;
};

}  // namespace

std::unique_ptr<ProbedRenderer> CreateReferenceRenderer(const RendererOptions& options) {
  if (options.precision == Precision::kFloat) {
    return std::make_unique<ReferenceRenderer<float>>(options);
  }
  return std::make_unique<ReferenceRenderer<double>>(options);
}

}  // namespace tetrec
