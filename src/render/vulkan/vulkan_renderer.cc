// Renderers on Vulkan: images, gradients and training steps with any integrator.
#include "render/vulkan/vulkan_renderer.h"

#include "core/error.h"
#include "render/field_checks.h"
#include "render/vulkan/device_memory.h"
#include "render/vulkan/device_sums.h"
#include "render/vulkan/edge_gather.h"
#include "render/vulkan/exposure_gather.h"
#include "render/vulkan/field_update.h"
#include "render/vulkan/fixed_point.h"
#include "render/vulkan/integrators.h"
#include "render/vulkan/pace.h"
#include "render/vulkan/pass_counters.h"
#include "render/vulkan/picture_passes.h"
#include "render/vulkan/ray_loss.h"
#include "render/vulkan/training_views.h"
#include "render/vulkan/view_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

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
        integrators_(*device_, options, layout_),
        recorders_{std::make_unique<CommandRecorder>(*device_),
                   std::make_unique<CommandRecorder>(*device_)},
        part_recorder_(*device_),
        views_(*device_),
        sums_(*device_),
        pictures_(*device_, options_, counters_, view_colors_) {}

  // Buffers are destroyed before the recorders, so the device must be done with them. It may be
  // lost.
  ~VulkanRenderer() override { vkDeviceWaitIdle(device_->handle); }

  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetState(field.mesh, StateOf(field));
  }

  void SetState(TetMesh mesh, const FieldState& state) override {
    CheckRenderable(mesh, state, options_.orientations);
    integrators_.rendering().CheckMesh(mesh);
    WaitAll();
    FreeMemory free = MeasureFreeMemory(*device_);
    if (field_.tet_count > 0) free.bytes += BytesOfField(field_.mesh, layout_);
    CheckMemory(mesh, BytesFor(mesh, state.layout), free);
    FreeField();  // before the new one takes memory
    UseLayout(state.layout);
    field_ = UploadField(*device_, std::move(mesh), state, options_.deterministic);
    SpreadParameters();
    integrators_.SetField(field_);
    views_.EnterField(field_);
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
    WaitAll();
    views_.SetTargets(views, targets);
    if (views.size() != exposures_.views()) ForgetExposures();
    if (field_.tet_count > 0) views_.EnterField(field_);
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
    sums_.Expect(fixed);
    if (HasPositions(batch.parts)) ExpectPositionSums(fixed);
    const StepResult before =
        InFlightBatch(integrators_.rendering(), batch, {ScaleOf(batch)}, fixed,
                      [&](CommandRecorder& recorder, const RayPass& pass) {
                        RecordLearning(recorder, pass, update, fixed);
                      });
    sums_.ForgetValues();
    return before;
  }

  StepResult Forward(const TrainingBatch& batch) override {
    WaitAll();
    forward_blocks_.assign(batch.blocks.begin(), batch.blocks.end());
    forward_batch_ = batch;
    forward_batch_.blocks = forward_blocks_;
    PutBlocks(part_.rays, batch.blocks);
    part_recorder_.Begin();
    RecordForward(part_recorder_,
                  part_.rays.columns > 0 ? integrators_.rendering() : integrators_.march(), part_,
                  ForwardPass(), batch, {ScaleOf(batch)});
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    has_forward_ = true;
    return Collect(part_);
  }

  void Backward(GradientParts parts) override {
    TETREC_CHECK(has_forward_, "Backward follows Forward");
    TETREC_CHECK(part_.rays.columns > 0 || !NeedsTiles(), "the batch of Backward is one tile");
    sums_.Expect(FixedPointOf(forward_batch_));
    AllocateOtherGradients(*device_, field_);
    if (HasPositions(parts)) ExpectPositionSums(sums_.quanta());
    RayPass pass = ForwardPass();
    pass.parts = parts;
    part_recorder_.Begin();
    RecordBackward(part_recorder_, pass);
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    sums_.HaveValues();
  }

  GradientSums TakeGradients() override {
    WaitAll();
    return sums_.Take(field_, sums_.quanta());
  }

  GradientSums TakePositionGradients() override {
    WaitAll();
    return sums_.TakePositions(field_);
  }

  void MoveVertices(std::span<const glm::vec3> positions) override {
    TETREC_CHECK(positions.size() == field_.vertex_count, "one position per vertex");
    WaitAll();
    has_forward_ = false;
    UploadPositions(field_, positions);
    SpreadParameters();
    integrators_.FollowVertices(field_);
    views_.EnterField(field_);
  }

  void AddGradients(const GradientSums& sums) override {
    WaitAll();
    if (!sums_.has_quanta()) {
      double largest = 0;
      for (const double value : sums.values) largest = std::max(largest, std::abs(value));
      sums_.Expect(FixedPointOf(largest, 1));
    }
    sums_.Add(field_, sums);
  }

  void Update(const AdamUpdate& update) override {
    WaitAll();
    part_recorder_.Begin();
    update_.Adam(part_recorder_, field_, update, sums_.quanta());
    update_.Others(part_recorder_, field_, update, sums_.quanta());
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
    sums_.ForgetValues();
  }

  void WriteParameters(std::span<const float> parameters) override {
    CheckRows(parameters, layout_, field_.row_count, "parameters");
    WaitAll();
    UploadParameters(field_, parameters);
    SpreadParameters();
  }

  void SetRowRates(std::span<const RowRates> rates) override {
    CheckRowRates(rates, field_.row_count);
    WaitAll();
    UploadRowRates(field_, rates);
  }

  DevicePace Pace() const override { return options_.pace.value_or(PaceOf(*device_)); }
  bool NeedsTiles() const override { return !integrators_.march_renders(); }

  void ClearScores() override {
    WaitAll();
    field_.tet_scores.FillZero();
    scored_rays_ = 0;
  }

  StepResult AddScores(const TrainingBatch& batch, ScoreKind kind) override {
    return Score(batch, [&](CommandRecorder& recorder, RayPass pass) {
      pass.score = kind;
      integrators_.march().Score(recorder, pass);
    });
  }

  TetScores ReadScores() override {
    WaitAll();
    return DownloadScores(field_);
  }

  void ClearEdgeSums(const MeshEdges& edges) override {
    WaitAll();
    edges_.Begin(*device_, edges, options_.deterministic);
    scored_rays_ = 0;
  }

  StepResult AddEdgeSums(const TrainingBatch& batch) override {
    return Score(batch, [&](CommandRecorder& recorder, const RayPass& pass) {
      integrators_.march().AddEdgeSums(recorder, pass, edges_, batch.background_srgb);
    });
  }

  std::vector<EdgeSums> TakeEdgeSums() override {
    WaitAll();
    return edges_.Take(double(field_.ball.w));
  }

  RenderedImage Render(const RenderView& view, int samples) override {
    WaitAll();
    has_forward_ = false;
    return pictures_.Render(integrators_.rendering(), field_, view, samples);
  }

  DepthMap RenderDepth(const RenderView& view, double optical_depth) override {
    WaitAll();
    has_forward_ = false;
    return pictures_.RenderDepth(integrators_.march(), field_, view, optical_depth);
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const bool with_positions = HasPositions(parts);
    WaitAll();
    TETREC_CHECK(pixel_gradient.size() == size_t(view.camera.width) * size_t(view.camera.height),
                 "one gradient per pixel");
    const FixedPoint fixed = FixedPointOf(LargestValue(pixel_gradient), pixel_gradient.size());
    TETREC_CHECK(!sums_.has_values(), "Backpropagate in the middle of a sum");
    if (with_positions) ExpectPositionSums(fixed);
    AllocateOtherGradients(*device_, field_);
    has_forward_ = false;
    pictures_.Backpropagate(integrators_.rendering(), field_, view, pixel_gradient, parts, fixed);
    const GradientSums sums = sums_.Take(field_, fixed);
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
    return pictures_.MarchBlocks(integrators_.rendering(), field_, view, blocks);
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
    const uint64_t on_device = BytesOfField(mesh, layout) + integrators_.BytesFor(mesh);
    const bool on_host = device_->properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    const uint64_t copies = mesh.tets.size() * (sizeof(glm::uvec4) * 4) +
                            mesh.positions.size() * (sizeof(glm::vec3) + sizeof(glm::vec4) * 2);
    return on_device + (on_host ? copies : 0);
  }

  uint64_t BytesOfField(const TetMesh& mesh, const FieldLayout& layout) const {
    return FieldBytes(mesh, layout, options_.deterministic, Pace().views_per_batch);
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
    integrators_.UseLayout(layout);
  }

  void FreeField() {
    field_ = {};
    view_colors_.Clear();
    sums_.ForgetValues();
    sums_.ForgetPositions();
    has_forward_ = false;
  }

  // Gives the renderers the field of the parameters.
  void SpreadParameters() {
    part_recorder_.Begin();
    update_.Spread(part_recorder_, field_);
    part_recorder_.EndAndSubmit();
    part_recorder_.Wait();
  }

  void ExpectPositionSums(const FixedPoint& quanta) {
    sums_.ExpectPositions(field_, quanta, [this] { WaitAll(); });
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

  // Records what scores the batch's rays. A gradient scale of 1/2 makes the rays' gradients of L2
  // the residuals themselves.
  template <class Record>
  StepResult Score(const TrainingBatch& batch, const Record& record) {
    scored_rays_ += batch.rays();
    TETREC_CHECK(!options_.deterministic || scored_rays_ <= kMostScoredRays,
                 fmt::format("scores of {} rays: the fixed-point sums are for {} at most",
                             scored_rays_, kMostScoredRays));
    TETREC_CHECK(batch.samples == 1, "scores take one ray per pixel");
    TrainingBatch by_square = batch;
    by_square.loss = LossKind::kL2;
    by_square.dssim_weight = 0;
    by_square.alpha_weight = 0;
    by_square.sums_exposures = false;
    FixedPoint fixed;
    fixed.largest_quanta = float(kLargestScore * kScoreQuanta);
    return InFlightBatch(integrators_.march(), by_square, {0.5f, true}, fixed, record);
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
    loss_.Record(recorder, slot, batch, gradients, views_.ViewsFor(batch).buffer, views_.targets(),
                 exposures_);
  }

  void RecordBackward(CommandRecorder& recorder, const RayPass& pass) {
    integrators_.rendering().Backward(recorder, pass);
    view_colors_.RecordBackward(recorder, pass);
  }

  // Backward pass and update. Coefficients of view-dependent colour make their step without sums of
  // their gradients, unless there are sums from before.
  void RecordLearning(CommandRecorder& recorder, const RayPass& pass, const AdamUpdate& update,
                      const FixedPoint& fixed) {
    if (sums_.has_values()) {
      RecordBackward(recorder, pass);
      update_.Others(recorder, field_, update, fixed);
    } else {
      integrators_.rendering().Backward(recorder, pass);
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

  void PutBlocks(RayBatch& rays, std::span<const RayBlock> blocks) {
    rays.SetBlocks(*device_, blocks, views_.of_pixels());
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

  // A pass over a batch of the training views.
  RayPass PassOver(RayBatch& rays, const TrainingBatch& batch, const FixedPoint& fixed) {
    const RayViews& of_batch = views_.ViewsFor(batch);
    RayPass pass =
        MakePass(field_, rays, of_batch.buffer, batch.blocks, of_batch.views[batch.blocks[0].view],
                 counters_.buffer(), options_.stop_transmittance, fixed);
    pass.push.jitter_seed = batch.seed;
    pass.push.jitter_px = batch.jitter_px;
    pass.parts = batch.parts;
    view_colors_.Bind(pass);
    return pass;
  }

  RendererOptions options_;
  std::unique_ptr<Device> device_;
  FieldLayout layout_;
  FieldUpdate update_;  // made for this layout
  RayLoss loss_;
  ExposureGather exposures_;  // of the training views
  PassCounters counters_;
  ViewColors view_colors_;   // made for layout_
  Integrators integrators_;  // made for layout_
  std::array<std::unique_ptr<CommandRecorder>, 2> recorders_;
  CommandRecorder part_recorder_;
  DeviceField field_;
  EdgeGather edges_;
  TrainingViews views_;
  std::array<BatchSlot, 2> in_flight_;  // of steps and scores
  BatchSlot part_;                      // for Forward and Backward
  TrainingBatch forward_batch_;         // that of the last Forward, with
  std::vector<RayBlock> forward_blocks_;
  bool has_forward_ = false;  // and nothing was rendered since
  DeviceSums sums_;
  int current_ = 0;
  uint64_t scored_rays_ = 0;  // since ClearScores
  PicturePasses pictures_;
};

}  // namespace

std::unique_ptr<ProbedRenderer> CreateVulkanRenderer(const RendererOptions& options) {
  return std::make_unique<VulkanRenderer>(options);
}

}  // namespace tetrec
