// Renderers on Vulkan: images, gradients and training steps with any integrator.
#include "render/vulkan/vulkan_renderer.h"

#include "core/error.h"
#include "mesh/locate.h"
#include "render/field_checks.h"
#include "render/vulkan/device_memory.h"
#include "render/vulkan/exposure_gather.h"
#include "render/vulkan/field_update.h"
#include "render/vulkan/fixed_point.h"
#include "render/vulkan/gpu_view.h"
#include "render/vulkan/march_integrator.h"
#include "render/vulkan/pass_counters.h"
#include "render/vulkan/picture_passes.h"
#include "render/vulkan/ppll_integrator.h"
#include "render/vulkan/projection_integrator.h"
#include "render/vulkan/ray_loss.h"
#include "render/vulkan/view_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

using gpu_types::GpuView;

double LargestValue(std::span<const glm::vec4> values) {
  float largest = 0.0f;
  for (const glm::vec4& value : values) {
    for (int i = 0; i < 4; ++i) largest = std::max(largest, std::abs(value[i]));
  }
  return largest;
}

DeviceOptions DeviceOptionsOf(const RendererOptions& options) {
  DeviceOptions device = options.device;
  device.int64_atomics |= options.deterministic;
  return device;
}

// Returns null for the march.
std::unique_ptr<Integrator> MakeOtherIntegrator(const Device& device,
                                                const RendererOptions& options,
                                                const FieldLayout& layout) {
  if (options.kind == RendererKind::kPpll) {
    return std::make_unique<PpllIntegrator>(device, options, layout);
  }
  if (options.kind == RendererKind::kProjection) {
    return std::make_unique<ProjectionIntegrator>(device, options, layout);
  }
  return nullptr;
}

// The training views as grids of rays, with one number of rays per pixel.
struct RayViews {
  std::vector<GpuView> views;
  Buffer buffer;  // the same
};

class VulkanRenderer final : public ProbedRenderer {
 public:
  explicit VulkanRenderer(const RendererOptions& options)
      : options_(options),
        device_(CreateDevice(DeviceOptionsOf(options))),
        update_(*device_, layout_, options.deterministic),
        loss_(*device_),
        exposures_(*device_),
        counters_(*device_),
        view_colors_(*device_, layout_, options.deterministic),
        march_(*device_, options),
        other_(MakeOtherIntegrator(*device_, options, layout_)),
        integrator_(other_ ? other_.get() : &march_),
        recorders_{std::make_unique<CommandRecorder>(*device_),
                   std::make_unique<CommandRecorder>(*device_)},
        part_recorder_(*device_),
        pictures_(*device_, options_, counters_, view_colors_) {}

  // Buffers are destroyed before the recorders, so the device must be done with them.
  ~VulkanRenderer() override { WaitAll(); }

  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetState(field.mesh, StateOf(field));
  }

  void SetState(TetMesh mesh, const FieldState& state) override {
    CheckRenderable(mesh, state, options_.orientations);
    integrator_->CheckMesh(mesh);
    WaitAll();
    FreeMemory free = MeasureFreeMemory(*device_);
    if (field_.tet_count > 0)
      free.bytes += FieldBytes(field_.mesh, layout_, options_.deterministic);
    CheckMemory(mesh, BytesFor(mesh, state.layout), free);
    FreeField();  // before the new one takes memory
    UseLayout(state.layout);
    field_ = UploadField(*device_, std::move(mesh), state, options_.deterministic);
    SpreadParameters();
    march_.SetField(field_);
    if (other_) other_->SetField(field_);
    UploadViews();
  }

  FieldState ReadState() override {
    WaitAll();
    return DownloadState(field_);
  }

  const TetMesh& mesh() const override { return field_.mesh; }

  TetMesh TakeMesh() override {
    WaitAll();
    TetMesh mesh = std::move(field_.mesh);
    FreeField();
    return mesh;
  }

  void SetTargets(std::span<const RenderView> views,
                  std::span<const TargetImage> targets) override {
    TETREC_CHECK(views.size() == targets.size(), "one target per view");
    WaitAll();
    views_.assign(views.begin(), views.end());
    first_pixels_.clear();
    std::vector<uint32_t> pixels;
    for (size_t i = 0; i < views.size(); ++i) {
      TETREC_CHECK(
          views[i].camera.width == targets[i].width && views[i].camera.height == targets[i].height,
          fmt::format("target {} and its camera differ in size", i));
      first_pixels_.push_back(uint32_t(pixels.size()));
      pixels.insert(pixels.end(), targets[i].rgba8.begin(), targets[i].rgba8.end());
    }
    targets_ = MakeBuffer(*device_, "target pictures", pixels, VK_FORMAT_R8G8B8A8_UNORM);
    if (views.size() != exposures_.views()) ForgetExposures();
    if (field_.tet_count > 0) UploadViews();
  }

  void SetExposures(std::span<const ViewExposure> exposures) override {
    TETREC_CHECK(exposures.size() == views_.size(), "one exposure per view");
    WaitAll();
    exposures_.SetExposures(exposures);
  }

  void AddExposureSums(std::span<ExposureSums> sums) override {
    WaitAll();
    exposures_.Collect(in_flight_[current_ ^ 1].rays);  // the older one
    exposures_.Collect(in_flight_[current_].rays);
    exposures_.TakeSums(sums);
  }

  // Two steps are in flight: while the device works on one, the host prepares the next.
  StepResult Step(const TrainingBatch& batch, const AdamUpdate& update) override {
    const FixedPoint fixed = FixedPointOf(batch);
    ExpectSums(fixed);
    if (batch.parts == GradientParts::kColorDensityPosition) {
      ExpectPositionSums(fixed);
    }
    const StepResult before = InFlightBatch(*integrator_, batch, {ScaleOf(batch)}, fixed,
                                            [&](CommandRecorder& recorder, const RayPass& pass) {
                                              RecordLearning(recorder, pass, update, fixed);
                                            });
    ForgetSums();
    return before;
  }

  StepResult Forward(const TrainingBatch& batch) override {
    WaitAll();
    forward_blocks_.assign(batch.blocks.begin(), batch.blocks.end());
    forward_batch_ = batch;
    forward_batch_.blocks = forward_blocks_;
    PutBlocks(part_.rays, batch.blocks);
    part_recorder_.Begin();
    RecordForward(part_recorder_, *integrator_, part_, ForwardPass(), batch, {ScaleOf(batch)});
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    has_forward_ = true;
    return Collect(part_);
  }

  void Backward(GradientParts parts) override {
    TETREC_CHECK(has_forward_, "Backward follows Forward");
    ExpectSums(FixedPointOf(forward_batch_));
    AllocateOtherGradients(*device_, field_);
    if (parts == GradientParts::kColorDensityPosition) ExpectPositionSums(sums_fixed_);
    RayPass pass = ForwardPass();
    pass.parts = parts;
    part_recorder_.Begin();
    RecordBackward(part_recorder_, pass);
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    has_sums_ = true;
  }

  GradientSums TakeGradients() override {
    WaitAll();
    return TakeSums(sums_fixed_);
  }

  GradientSums TakePositionGradients() override {
    WaitAll();
    GradientSums sums;
    TakePositionSums(sums);
    return sums;
  }

  void MoveVertices(std::span<const glm::vec3> positions) override {
    TETREC_CHECK(positions.size() == field_.vertex_count, "one position per vertex");
    WaitAll();
    has_forward_ = false;
    UploadPositions(field_, positions);
    SpreadParameters();
    if (other_) other_->FollowVertices(field_);
    UploadViews();
  }

  void AddGradients(const GradientSums& sums) override {
    WaitAll();
    if (!has_quanta_) {
      double largest = 0;
      for (const double value : sums.values) largest = std::max(largest, std::abs(value));
      ExpectSums(FixedPointOf(largest, 1));
    }
    AllocateOtherGradients(*device_, field_);
    AddToGradients(field_, sums.values, sums_fixed_);
    has_sums_ = true;
    if (sums.position.empty()) return;
    ExpectPositionSums(sums_fixed_);
    std::vector<double> rows;
    for (size_t v = 0; v < sums.position.size(); ++v) {
      for (int i = 0; i < 3; ++i) rows.push_back(sums.position[v][i]);
      rows.push_back(sums.absolute_position[v]);
    }
    AddToPositionGradients(field_, rows, sums_fixed_);
  }

  void Update(const AdamUpdate& update) override {
    WaitAll();
    part_recorder_.Begin();
    update_.Adam(part_recorder_, field_, update, sums_fixed_);
    update_.Others(part_recorder_, field_, update, sums_fixed_);
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    ForgetSums();
  }

  void WriteParameters(std::span<const float> parameters) override {
    CheckRows(parameters, layout_, field_.row_count, "parameters");
    WaitAll();
    UploadParameters(field_, parameters);
    SpreadParameters();
  }

  void SetRateShares(std::span<const float> shares) override {
    CheckRateShares(shares, field_.row_count);
    WaitAll();
    field_.rate_shares.Upload(shares.data(), shares.size_bytes());
  }

  bool NeedsTiles() const override { return integrator_ != &march_; }

  void ClearScores() override {
    WaitAll();
    field_.tet_scores.FillZero();
    scored_rays_ = 0;
  }

  // A gradient scale of 1/2 makes the rays' gradients of L2 the residuals themselves.
  StepResult AddScores(const TrainingBatch& batch, ScoreKind kind) override {
    scored_rays_ += batch.rays();
    TETREC_CHECK(!options_.deterministic || scored_rays_ <= kMostScoredRays,
                 fmt::format("scores of {} rays: the fixed-point sums are for {} at most",
                             scored_rays_, kMostScoredRays));
    TrainingBatch by_square = batch;
    by_square.loss = LossKind::kL2;
    by_square.dssim_weight = 0;
    by_square.sums_exposures = false;
    TETREC_CHECK(batch.samples == 1, "scores take one ray per pixel");
    FixedPoint fixed;
    fixed.largest_quanta = float(kLargestScore * kScoreQuanta);
    return InFlightBatch(march_, by_square, {0.5f, true}, fixed,
                         [&](CommandRecorder& recorder, const RayPass& pass) {
                           RayPass scored = pass;
                           scored.score = kind;
                           march_.Score(recorder, scored);
                         });
  }

  std::vector<float> ReadScores() override {
    WaitAll();
    return DownloadScores(field_);
  }

  RenderedImage Render(const RenderView& view, int samples) override {
    WaitAll();
    has_forward_ = false;
    return pictures_.Render(*integrator_, field_, view, samples);
  }

  DepthMap RenderDepth(const RenderView& view) override {
    WaitAll();
    has_forward_ = false;
    return pictures_.RenderDepth(march_, field_, view);
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    WaitAll();
    TETREC_CHECK(pixel_gradient.size() == size_t(view.camera.width) * size_t(view.camera.height),
                 "one gradient per pixel");
    const FixedPoint fixed = FixedPointOf(LargestValue(pixel_gradient), pixel_gradient.size());
    TETREC_CHECK(!has_sums_, "Backpropagate in the middle of a sum");
    if (with_positions) ExpectPositionSums(fixed);
    AllocateOtherGradients(*device_, field_);
    has_forward_ = false;
    pictures_.Backpropagate(*integrator_, field_, view, pixel_gradient, parts, fixed);
    const GradientSums sums = TakeSums(fixed);
    FieldGradient result;
    const size_t components = size_t(layout_.Components());
    for (size_t at = 0; at < sums.values.size(); at += components) {
      const double* row = &sums.values[at];
      result.color_srgb.emplace_back(row[kColorOffset], row[kColorOffset + 1],
                                     row[kColorOffset + 2]);
      result.density.push_back(float(row[kDensityOffset]));
    }
    result.position.assign(sums.position.begin(), sums.position.end());
    result.absolute_position.assign(sums.absolute_position.begin(), sums.absolute_position.end());
    return result;
  }

  std::vector<glm::vec4> MarchBlocks(const RenderView& view,
                                     std::span<const RayBlock> blocks) override {
    WaitAll();
    has_forward_ = false;
    return pictures_.MarchBlocks(*integrator_, field_, view, blocks);
  }

  RenderCounts counts() const override {
    WaitAll();
    RenderCounts counts = counters_.Counts();
    counts.device_bytes = device_->memory_use->most_bytes;
    return counts;
  }

  std::vector<std::string> ValidationMessages() const override {
    return device_->validation_messages;
  }

  nlohmann::json DescribeDevice() const override { return tetrec::DescribeDevice(*device_); }

  KernelReport KernelTimes() const override {
    WaitAll();
    KernelReport report;
    if (!device_->kernel_times) return report;
    report.has_timestamps = true;
    report.untimed_calls = device_->kernel_times->untimed_calls;
    for (const auto& [name, entry] : device_->kernel_times->by_name) {
      report.kernels.push_back({name, entry.calls, entry.seconds});
    }
    return report;
  }

 private:
  // An upper bound. On a software device the host's copy of the mesh, and the rows that it is
  // uploaded from, count, too.
  uint64_t BytesFor(const TetMesh& mesh, const FieldLayout& layout) const {
    const uint64_t on_device = FieldBytes(mesh, layout, options_.deterministic) +
                               march_.BytesFor(mesh) + (other_ ? other_->BytesFor(mesh) : 0);
    const bool on_host = device_->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    const uint64_t copies = mesh.tets.size() * (sizeof(glm::uvec4) * 4) +
                            mesh.positions.size() * (sizeof(glm::vec3) + sizeof(glm::vec4) * 2);
    return on_device + (on_host ? copies : 0);
  }

  void WaitAll() const {
    for (const auto& recorder : recorders_) recorder->Wait();
  }

  // Makes the kernels that know where the field keeps its attributes.
  void UseLayout(const FieldLayout& layout) {
    if (layout == layout_) return;
    layout_ = layout;
    update_ = FieldUpdate(*device_, layout, options_.deterministic);
    view_colors_ = ViewColors(*device_, layout, options_.deterministic);
    other_ = MakeOtherIntegrator(*device_, options_, layout);
    integrator_ = other_ ? other_.get() : &march_;
  }

  void FreeField() {
    field_ = {};
    view_colors_.Clear();
    ForgetSums();
    ForgetPositionSums();
    has_forward_ = false;
  }

  // Gives the renderers the field of the parameters.
  void SpreadParameters() {
    part_recorder_.Begin();
    update_.Spread(part_recorder_, field_);
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
  }

  // Gradients are about to be added that count in these quanta.
  void ExpectSums(const FixedPoint& fixed) {
    TETREC_CHECK(!has_sums_ || fixed == sums_fixed_,
                 "batches summed for one update agree in rays_of_mean, loss and dssim_weight");
    sums_fixed_ = fixed;
    has_quanta_ = true;
  }

  // The sums are zero, or will be when the device is done.
  void ForgetSums() { has_sums_ = has_quanta_ = false; }

  GradientSums TakeSums(const FixedPoint& fixed) {
    GradientSums sums;
    sums.values = DownloadGradients(field_, fixed);
    ClearGradients(field_);
    has_sums_ = false;
    TakePositionSums(sums);
    return sums;
  }

  // Gradients by positions are about to be added that count in these quanta. They may be others
  // than before: sums of positions are of several updates.
  void ExpectPositionSums(const FixedPoint& fixed) {
    AllocatePositionGradients(*device_, field_);
    if (has_position_sums_ && fixed.position_quanta != position_fixed_.position_quanta) {
      WaitAll();
      AddPositionSums(counted_positions_);
    }
    position_fixed_ = fixed;
    has_position_sums_ = true;
  }

  // Adds the sums on the device to `sums` and sets them to zero.
  void AddPositionSums(GradientSums& sums) {
    sums.position.resize(field_.vertex_count, glm::dvec3(0.0));
    sums.absolute_position.resize(field_.vertex_count, 0.0);
    const std::vector<double> rows = DownloadPositionGradients(field_, position_fixed_);
    for (size_t v = 0; v < sums.position.size(); ++v) {
      sums.position[v] += glm::dvec3(rows[4 * v], rows[4 * v + 1], rows[4 * v + 2]);
      sums.absolute_position[v] += rows[4 * v + 3];
    }
    field_.position_gradients.FillZero();
  }

  void TakePositionSums(GradientSums& sums) {
    if (!has_position_sums_) return;
    AddPositionSums(counted_positions_);
    sums.position = std::move(counted_positions_.position);
    sums.absolute_position = std::move(counted_positions_.absolute_position);
    ForgetPositionSums();
  }

  void ForgetPositionSums() {
    counted_positions_ = {};
    has_position_sums_ = false;
  }

  // Records forward and loss of a batch and whatever `then` records, and submits it. Returns the
  // losses of the batch before last.
  template <class Then>
  StepResult InFlightBatch(Integrator& integrator, const TrainingBatch& batch,
                           const RayGradients& gradients, const FixedPoint& fixed,
                           const Then& then) {
    current_ ^= 1;
    CommandRecorder& recorder = *recorders_[current_];
    BatchSlot& slot = in_flight_[current_];
    recorder.Wait();
    const StepResult before = Collect(slot);
    PutBlocks(slot.rays, batch.blocks);
    const RayPass pass = PassOver(slot.rays, batch, fixed);
    recorder.Begin();
    RecordForward(recorder, integrator, slot, pass, batch, gradients);
    then(recorder, pass);
    recorder.EndAndSubmit();
    has_forward_ = false;
    return before;
  }

  // The pass over the batch of Forward.
  RayPass ForwardPass() {
    return PassOver(part_.rays, forward_batch_, FixedPointOf(forward_batch_));
  }

  void RecordForward(CommandRecorder& recorder, Integrator& integrator, BatchSlot& slot,
                     const RayPass& pass, const TrainingBatch& batch,
                     const RayGradients& gradients) {
    view_colors_.Record(recorder, pass);
    integrator.Forward(recorder, pass);
    if (batch.dssim_weight > 0) CheckTiles(batch);
    loss_.Record(recorder, slot, batch, gradients, RaysOf(batch).buffer, targets_, exposures_);
  }

  void RecordBackward(CommandRecorder& recorder, const RayPass& pass) {
    integrator_->Backward(recorder, pass);
    view_colors_.RecordBackward(recorder, pass);
  }

  // Backward pass and update. Coefficients of view-dependent colour make their step without sums of
  // their gradients, unless there are sums from before.
  void RecordLearning(CommandRecorder& recorder, const RayPass& pass, const AdamUpdate& update,
                      const FixedPoint& fixed) {
    if (has_sums_) {
      RecordBackward(recorder, pass);
      update_.Others(recorder, field_, update, fixed);
    } else {
      integrator_->Backward(recorder, pass);
      view_colors_.RecordStep(recorder, pass, update, fixed);
    }
    update_.Adam(recorder, field_, update, fixed);
  }

  // For other views than before.
  void ForgetExposures() {
    for (BatchSlot* slot : {&in_flight_[0], &in_flight_[1], &part_})
      slot->rays.summed_views.clear();
    exposures_.ForgetSums();
    SetExposures(std::vector<ViewExposure>(views_.size()));
  }

  // Sums the losses of a batch that the device is done with, and keeps its exposure sums.
  StepResult Collect(BatchSlot& slot) {
    exposures_.Collect(slot.rays);
    return RayLoss::Collect(slot);
  }

  void UploadViews() {
    for (RayViews& rays : ray_views_) rays.views.clear();
    uint32_t tet = 0;
    for (size_t i = 0; i < views_.size(); ++i) {
      tet = FindTet(field_.mesh, views_[i].cam_from_world.Inverse().translation,
                    tet == kNoTet ? 0 : tet, field_.not_convex.empty());
      for (int samples = 1; samples <= kMostTrainingSamples; ++samples) {
        ray_views_[size_t(samples - 1)].views.push_back(
            MakeGpuView(views_[i], samples, first_pixels_[i], tet));
      }
    }
    for (RayViews& rays : ray_views_) {
      rays.buffer = MakeBuffer(*device_, "views", rays.views, VK_FORMAT_R32G32B32A32_UINT);
    }
  }

  void PutBlocks(RayBatch& rays, std::span<const RayBlock> blocks) {
    rays.SetBlocks(*device_, blocks, ray_views_[0].views);
    if (view_colors_.NeedsRoom(field_, rays.slots)) {
      WaitAll();  // for the other batch in flight
      view_colors_.MakeRoom(field_, rays.slots);
    }
    counters_.AddRays(rays.count);
  }

  static float ScaleOf(const TrainingBatch& batch) {
    return 1.0f / float(3 * batch.rays_of_mean());
  }

  // For the sums of an update.
  FixedPoint FixedPointOf(const TrainingBatch& batch) const {
    return FixedPointOf(GradientScale(batch), batch.rays_of_mean());
  }

  FixedPoint FixedPointOf(double gradient_scale, uint64_t rays) const {
    if (!options_.deterministic) return {};
    return ChooseFixedPoint(gradient_scale, rays, field_.most_tets_at_vertex, field_.diagonal);
  }

  const RayViews& RaysOf(const TrainingBatch& batch) const {
    TETREC_CHECK(batch.samples >= 1 && batch.samples <= kMostTrainingSamples,
                 "1 or 2 x 2 rays per pixel");
    TETREC_CHECK(batch.samples == 1 || batch.dssim_weight == 0, "D-SSIM takes one ray per pixel");
    return ray_views_[size_t(batch.samples - 1)];
  }

  // A pass over a batch of the training views.
  RayPass PassOver(RayBatch& rays, const TrainingBatch& batch, const FixedPoint& fixed) {
    const RayViews& of_batch = RaysOf(batch);
    RayPass pass =
        MakePass(field_, rays, of_batch.buffer, batch.blocks, of_batch.views[batch.blocks[0].view],
                 counters_.buffer(), options_.stop_transmittance, fixed);
    pass.push.jitter_seed = batch.seed;
    pass.push.jitter_px = batch.jitter_px;
    pass.parts = batch.parts;
    view_colors_.Bind(pass);
    return pass;
  }

  // Windows must not reach beyond an image, where rays have no target.
  void CheckTiles(const TrainingBatch& batch) const {
    for (const RayBlock& block : batch.blocks) {
      const Camera& camera = views_[block.view].camera;
      TETREC_CHECK(int(block.x) + kRayBlockWidth <= camera.width &&
                       int(block.y) + kRayBlockHeight <= camera.height,
                   "a tile of D-SSIM leaves its picture");
    }
  }

  RendererOptions options_;
  std::unique_ptr<Device> device_;
  FieldLayout layout_;
  FieldUpdate update_;  // made for this layout
  RayLoss loss_;
  ExposureGather exposures_;  // of the training views
  PassCounters counters_;
  ViewColors view_colors_;             // made for layout_
  MarchIntegrator march_;              // for scores, whichever integrator renders
  std::unique_ptr<Integrator> other_;  // unless the march renders
  Integrator* integrator_;
  std::array<std::unique_ptr<CommandRecorder>, 2> recorders_;
  CommandRecorder part_recorder_;
  DeviceField field_;
  Buffer targets_;
  std::vector<RenderView> views_;
  std::array<RayViews, kMostTrainingSamples> ray_views_;  // by TrainingBatch::samples, from 1 on
  std::vector<uint32_t> first_pixels_;
  std::array<BatchSlot, 2> in_flight_;  // of steps and scores
  BatchSlot part_;                      // for Forward and Backward
  TrainingBatch forward_batch_;         // that of the last Forward, with
  std::vector<RayBlock> forward_blocks_;
  bool has_forward_ = false;        // and nothing was rendered since
  bool has_sums_ = false;           // gradients that no update has used
  bool has_position_sums_ = false;  // nor was taken
  FixedPoint position_fixed_;       // their quanta
  GradientSums counted_positions_;  // sums of positions in other quanta
  bool has_quanta_ = false;         // sums_fixed_ is known since the last update
  FixedPoint sums_fixed_;
  int current_ = 0;
  uint64_t scored_rays_ = 0;  // since ClearScores
  PicturePasses pictures_;
};

}  // namespace

std::unique_ptr<ProbedRenderer> CreateVulkanRenderer(const RendererOptions& options) {
  return std::make_unique<VulkanRenderer>(options);
}

}  // namespace tetrec
