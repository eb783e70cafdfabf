// Renderers on Vulkan: images, gradients and training steps with any integrator.
#include "render/vulkan/vulkan_renderer.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "mesh/locate.h"
#include "render/adam_push.h"
#include "render/field_checks.h"
#include "render/ray_blocks.h"
#include "render/vulkan/device_memory.h"
#include "render/vulkan/dssim_loss.h"
#include "render/vulkan/fixed_point.h"
#include "render/vulkan/march_integrator.h"
#include "render/vulkan/ppll_integrator.h"
#include "render/vulkan/projection_integrator.h"
#include "shared/loss.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

using gpu_types::AdamPush;
using gpu_types::GpuView;
using gpu_types::LossPush;
using gpu_types::RayPush;
using gpu_types::SpreadPush;

// The number of rays per submit while rendering images. It bounds the ray buffers, the workgroups
// of a dispatch and the values of the device's 32-bit counters.
constexpr uint32_t kRaysPerSubmit = 1u << 17;

// `grid` rays per side of a pixel; `start_tet` as FindTet returns it.
GpuView MakeGpuView(const RenderView& view, int grid, uint32_t first_pixel, uint32_t start_tet) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const Camera& camera = view.camera;
  GpuView result;
  result.right_in_world_fx = glm::vec4(glm::dvec4(world_from_cam.rotation[0], grid * camera.fx));
  result.down_in_world_fy = glm::vec4(glm::dvec4(world_from_cam.rotation[1], grid * camera.fy));
  result.forward_in_world_cx = glm::vec4(glm::dvec4(world_from_cam.rotation[2], grid * camera.cx));
  result.center_in_world_cy = glm::vec4(glm::dvec4(world_from_cam.translation, grid * camera.cy));
  result.size_pixel_tet = glm::uvec4(uint32_t(grid * camera.width), uint32_t(grid * camera.height),
                                     first_pixel, start_tet);
  return result;
}

Program AdamProgram(const Device& device, const FieldLayout& layout, bool fixed_point) {
  static_assert(kMostAttributes == kMostLayoutAttributes && kMostComponents < 256);
  static_assert(kColorOffset == kColorComponent && kDensityOffset == kDensityComponent);
  std::vector<SpecializationConstant> constants = ConstantsOf(layout);
  constants.push_back({kConstantAttributeCount, int32_t(layout.attributes.size())});
  uint32_t id = kConstantAttributes;
  for (const Attribute& attribute : layout.attributes) {
    constants.push_back({id++, attribute.components | int32_t(attribute.activation) << 8 |
                                   int32_t(attribute.rate) << 16});
  }
  const std::span<const uint32_t> fixed = kAdamFixed, floats = kAdam;
  return Program(device, "adam", fixed_point ? fixed : floats, constants);
}

Program SpreadProgram(const Device& device, const FieldLayout& layout) {
  return Program(device, "spread", kSpread, ConstantsOf(layout));
}

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

// A training batch on the device.
struct BatchSlot {
  RayBatch rays;
  DssimBatch dssim;
  uint32_t uncollected_rays = 0;  // whose losses are yet to be read
  // The views of the blocks whose exposure sums are yet to be read.
  std::vector<uint32_t> uncollected_views;
};

// What the loss leaves in RayBatch::gradients.
struct RayGradients {
  float scale = 1;             // of the loss
  bool are_residuals = false;  // by what is shown, for scores
};

class VulkanRenderer final : public ProbedRenderer {
 public:
  explicit VulkanRenderer(const RendererOptions& options)
      : options_(options),
        device_(CreateDevice(DeviceOptionsOf(options))),
        loss_(*device_, "loss", kLoss),
        exposure_sums_(*device_, "exposure_sums", kExposureSums),
        adam_(AdamProgram(*device_, layout_, options.deterministic)),
        spread_(SpreadProgram(*device_, layout_)),
        march_(*device_, options),
        other_(MakeOtherIntegrator(*device_, options, layout_)),
        integrator_(other_ ? other_.get() : &march_),
        recorders_{std::make_unique<CommandRecorder>(*device_),
                   std::make_unique<CommandRecorder>(*device_)},
        render_recorder_(*device_),
        counters_(*device_, "counters", kCounterCount * 4),
        render_view_(*device_, "view", sizeof(GpuView), VK_FORMAT_R32G32B32A32_UINT) {
    counters_.FillZero();
  }

  // Buffers are destroyed before the recorders, so the device must be done with them.
  ~VulkanRenderer() override { WaitAll(); }

  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetState(field.mesh, StateOf(field));
  }

  void SetState(const TetMesh& mesh, const FieldState& state) override {
    CheckRenderable(mesh, state);
    integrator_->CheckMesh(mesh);
    WaitAll();
    FreeMemory free = MeasureFreeMemory(*device_);
    if (field_.tet_count > 0)
      free.bytes += FieldBytes(field_.mesh, layout_, options_.deterministic);
    CheckMemory(mesh, BytesFor(mesh, state.layout), free);
    field_ = {};  // frees the old mesh before the new one takes memory
    UseLayout(state.layout);
    field_ = UploadField(*device_, mesh, state, options_.deterministic);
    SpreadParameters();
    ForgetSums();
    has_forward_ = false;
    march_.SetField(field_);
    if (other_) other_->SetField(field_);
    UploadViews();
  }

  FieldState ReadState() override {
    WaitAll();
    return DownloadState(field_);
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
    if (views.size() != exposed_views_) ForgetExposures();
    if (field_.tet_count > 0) UploadViews();
  }

  void SetExposures(std::span<const ViewExposure> exposures) override {
    TETREC_CHECK(exposures.size() == views_.size(), "one exposure per view");
    WaitAll();
    std::vector<glm::vec4> texels;
    for (const ViewExposure& exposure : exposures) {
      texels.emplace_back(glm::vec3(exposure.gain), 0.0f);
      texels.emplace_back(glm::vec3(exposure.offset), 0.0f);
    }
    exposed_views_ = exposures.size();
    exposures_ = MakeBuffer(*device_, "exposures", texels, VK_FORMAT_R32G32B32A32_SFLOAT);
  }

  void AddExposureSums(std::span<ExposureSums> sums) override {
    WaitAll();
    CollectExposureSums(in_flight_[current_ ^ 1]);  // the older one
    CollectExposureSums(in_flight_[current_]);
    AddBlockSums(block_sums_, sums);
    block_sums_.clear();
  }

  // Two steps are in flight: while the device works on one, the host prepares the next.
  StepResult Step(const TrainingBatch& batch, const AdamUpdate& update) override {
    const FixedPoint fixed = FixedPointOf(batch);
    ExpectSums(fixed);
    const StepResult before = InFlightBatch(*integrator_, batch, {ScaleOf(batch)}, fixed,
                                            [&](CommandRecorder& recorder, const RayPass& pass) {
                                              integrator_->Backward(recorder, pass);
                                              RecordUpdate(recorder, update, fixed);
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
    render_recorder_.Begin();
    RecordForward(render_recorder_, *integrator_, part_, ForwardPass(), batch, {ScaleOf(batch)});
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    has_forward_ = true;
    return Collect(part_);
  }

  void Backward(GradientParts parts) override {
    TETREC_CHECK(has_forward_, "Backward follows Forward");
    ExpectSums(FixedPointOf(forward_batch_));
    if (parts == GradientParts::kColorDensityPosition) {
      AllocatePositionGradients(*device_, field_);
      has_position_sums_ = true;
    }
    RayPass pass = ForwardPass();
    pass.parts = parts;
    render_recorder_.Begin();
    integrator_->Backward(render_recorder_, pass);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    has_sums_ = true;
  }

  GradientSums TakeGradients() override {
    WaitAll();
    return TakeSums(sums_fixed_);
  }

  void AddGradients(const GradientSums& sums) override {
    WaitAll();
    if (!has_quanta_) {
      double largest = 0;
      for (const double value : sums.values) largest = std::max(largest, std::abs(value));
      ExpectSums(FixedPointOf(largest, 1));
    }
    AddToSums(field_, field_.gradients, sums.values, QuantaOf(layout_, sums_fixed_));
    has_sums_ = true;
    if (sums.position.empty()) return;
    AllocatePositionGradients(*device_, field_);
    std::vector<double> rows;
    for (size_t v = 0; v < sums.position.size(); ++v) {
      for (int i = 0; i < 3; ++i) rows.push_back(sums.position[v][i]);
      rows.push_back(sums.absolute_position[v]);
    }
    const double quanta[] = {double(sums_fixed_.position_quanta)};
    AddToSums(field_, field_.position_gradients, rows, quanta);
    has_position_sums_ = true;
  }

  void Update(const AdamUpdate& update) override {
    WaitAll();
    render_recorder_.Begin();
    RecordUpdate(render_recorder_, update, sums_fixed_);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    ForgetSums();
  }

  void WriteParameters(std::span<const float> parameters) override {
    CheckRows(parameters, layout_, field_.row_count, "parameters");
    WaitAll();
    field_.parameters.Upload(parameters.data(), parameters.size_bytes());
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
    const int width = view.camera.width, height = view.camera.height;
    UploadRenderView(view, samples);
    RenderedImage image{width, height, std::vector<glm::vec3>(size_t(width) * height),
                        std::vector<float>(size_t(width) * height)};
    const float share = 1.0f / float(samples * samples);
    ForEachBatch(CoveringBlocks(width * samples, height * samples),
                 [&](std::span<const RayBlock> blocks) {
                   const std::vector<glm::vec4> colors = MarchBatch(blocks);
                   for (size_t r = 0; r < colors.size(); ++r) {
                     const glm::ivec2 at = PixelOfRay(blocks, r);
                     if (at.x >= width * samples || at.y >= height * samples) continue;
                     const size_t pixel = size_t(at.y / samples) * width + at.x / samples;
                     image.color_srgb[pixel] += share * glm::vec3(colors[r]);
                     image.transmittance[pixel] += share * std::exp(-colors[r].a);
                   }
                 });
    return image;
  }

  DepthMap RenderDepth(const RenderView& view) override {
    WaitAll();
    const int width = view.camera.width, height = view.camera.height;
    UploadRenderView(view, 1);
    DepthMap map = MakeDepthMap(width, height);
    ForEachBatch(CoveringBlocks(width, height), [&](std::span<const RayBlock> blocks) {
      const std::vector<float> reaches = ReachesOfBatch(blocks);
      for (size_t r = 0; r < reaches.size(); ++r) {
        const glm::ivec2 at = PixelOfRay(blocks, r);
        if (at.x < width && at.y < height && reaches[r] > 0) {
          map.At(at.x, at.y) = float(DepthOfDistance(view.camera, at, double(reaches[r])));
        }
      }
    });
    return map;
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    WaitAll();
    const int width = view.camera.width, height = view.camera.height;
    TETREC_CHECK(pixel_gradient.size() == size_t(width) * height, "one gradient per pixel");
    UploadRenderView(view, 1);
    const FixedPoint fixed = FixedPointOf(LargestValue(pixel_gradient), pixel_gradient.size());
    TETREC_CHECK(!has_sums_, "Backpropagate in the middle of a sum");
    if (with_positions) AllocatePositionGradients(*device_, field_);
    ForEachBatch(CoveringBlocks(width, height), [&](std::span<const RayBlock> blocks) {
      MarchBatch(blocks);
      std::vector<glm::vec4> gradients(blocks.size() * kRaysPerBlock, glm::vec4(0.0f));
      for (size_t r = 0; r < gradients.size(); ++r) {
        const glm::ivec2 at = PixelOfRay(blocks, r);
        if (at.x < width && at.y < height) {
          gradients[r] = pixel_gradient[size_t(at.y) * width + at.x];
        }
      }
      picture_rays_.gradients.Upload(gradients);
      render_recorder_.Begin();
      RayPass pass = RenderPass(blocks, fixed);
      pass.parts = parts;
      integrator_->Backward(render_recorder_, pass);
      render_recorder_.EndAndSubmit();
      render_recorder_.Wait();
    });
    has_position_sums_ = with_positions;
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
    UploadRenderView(view, 1);
    std::vector<glm::vec4> rays;
    rays.reserve(blocks.size() * kRaysPerBlock);
    ForEachBatch(blocks, [&](std::span<const RayBlock> batch) {
      const std::vector<glm::vec4> colors = MarchBatch(batch);
      rays.insert(rays.end(), colors.begin(), colors.end());
    });
    return rays;
  }

  RenderCounts counts() const override {
    WaitAll();
    RenderCounts counts = counts_;
    AddCounters(counts);
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
  // An upper bound. On a software device the host's copies count, too.
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
    adam_ = AdamProgram(*device_, layout, options_.deterministic);
    spread_ = SpreadProgram(*device_, layout);
    other_ = MakeOtherIntegrator(*device_, options_, layout);
    integrator_ = other_ ? other_.get() : &march_;
  }

  // Gives the renderers the field of the parameters.
  void SpreadParameters() {
    render_recorder_.Begin();
    render_recorder_.DispatchMany(
        spread_, {{kBindParameters, field_.parameters}, {kBindVertices, field_.vertices}},
        SpreadPush{field_.row_count, field_.first_cell}, field_.row_count);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
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
    sums.values = DownloadSums(field_, field_.gradients, QuantaOf(layout_, fixed));
    field_.gradients.FillZero();
    has_sums_ = false;
    if (!std::exchange(has_position_sums_, false)) return sums;
    const double quanta[] = {double(fixed.position_quanta)};
    const std::vector<double> rows = DownloadSums(field_, field_.position_gradients, quanta);
    for (size_t at = 0; at < rows.size(); at += 4) {
      sums.position.emplace_back(rows[at], rows[at + 1], rows[at + 2]);
      sums.absolute_position.push_back(rows[at + 3]);
    }
    field_.position_gradients.FillZero();
    return sums;
  }

  void AddCounters(RenderCounts& counts) const {
    const auto counters = counters_.DownloadAs<uint32_t>(kCounterCount);
    counts.lost_rays += counters[kCounterLostRays];
    counts.clamped_addends += counters[kCounterClamped];
    counts.hit_rays += counters[kCounterHitRays];
    counts.steps += counters[kCounterSteps];
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
    const RayPass pass = PassOver(slot.rays, training_views_, batch.blocks,
                                  gpu_views_[batch.blocks[0].view], batch, fixed);
    recorder.Begin();
    RecordForward(recorder, integrator, slot, pass, batch, gradients);
    then(recorder, pass);
    recorder.EndAndSubmit();
    has_forward_ = false;
    return before;
  }

  // The pass over the batch of Forward.
  RayPass ForwardPass() {
    return PassOver(part_.rays, training_views_, forward_blocks_,
                    gpu_views_[forward_blocks_[0].view], forward_batch_,
                    FixedPointOf(forward_batch_));
  }

  void RecordForward(CommandRecorder& recorder, Integrator& integrator, BatchSlot& slot,
                     const RayPass& pass, const TrainingBatch& batch,
                     const RayGradients& gradients) {
    integrator.Forward(recorder, pass);
    RecordLoss(recorder, slot, batch, gradients);
    slot.uncollected_rays = slot.rays.count;
  }

  // For other views than before.
  void ForgetExposures() {
    for (BatchSlot* slot : {&in_flight_[0], &in_flight_[1], &part_}) {
      slot->uncollected_views.clear();
    }
    block_sums_.clear();
    SetExposures(std::vector<ViewExposure>(views_.size()));
  }

  // Keeps the exposure sums of a batch that the device is done with.
  void CollectExposureSums(BatchSlot& slot) {
    const std::vector<uint32_t> views = std::exchange(slot.uncollected_views, {});
    const auto rows = slot.rays.exposure_sums.DownloadAs<glm::vec4>(views.size() * 4);
    for (size_t block = 0; block < views.size(); ++block) {
      BlockExposureSums sums{views[block], {}};
      for (size_t c = 0; c < 3; ++c) {
        const glm::dvec4 row(rows[4 * block + c]);
        sums.sums[c] = {double(rows[4 * block + 3].x), row[0], row[1], row[2], row[3]};
      }
      block_sums_.push_back(sums);
    }
  }

  // Sums the losses of a batch that the device is done with, and keeps its exposure sums.
  StepResult Collect(BatchSlot& slot) {
    CollectExposureSums(slot);
    const uint32_t rays = std::exchange(slot.uncollected_rays, 0);
    StepResult result;
    if (rays == 0) return result;
    const uint32_t groups = (rays + kWorkgroupSize - 1) / kWorkgroupSize;
    for (const glm::vec2& partial : slot.rays.partial_losses.DownloadAs<glm::vec2>(groups)) {
      result.loss += partial.x;
      result.squared_error += partial.y;
    }
    result.loss = slot.dssim.Mix(result.loss / (3.0 * rays));
    result.squared_error /= 3.0 * rays;
    return result;
  }

  void UploadViews() {
    gpu_views_.clear();
    uint32_t tet = 0;
    for (size_t i = 0; i < views_.size(); ++i) {
      tet = FindTet(field_.mesh, views_[i].cam_from_world.Inverse().translation,
                    tet == kNoTet ? 0 : tet, field_.not_convex.empty());
      gpu_views_.push_back(MakeGpuView(views_[i], 1, first_pixels_[i], tet));
    }
    training_views_ = MakeBuffer(*device_, "views", gpu_views_, VK_FORMAT_R32G32B32A32_UINT);
  }

  void UploadRenderView(const RenderView& view, int samples) {
    const uint32_t tet = FindTet(field_.mesh, view.cam_from_world.Inverse().translation, 0,
                                 field_.not_convex.empty());
    gpu_render_view_ = MakeGpuView(view, samples, 0, tet);
    render_view_.Upload(&gpu_render_view_, sizeof(gpu_render_view_));
  }

  void PutBlocks(RayBatch& rays, std::span<const RayBlock> blocks) {
    rays.SetBlocks(*device_, blocks);
    counts_.rays += rays.count;
  }

  // Batches of a tile are whole rows of its blocks, so each is a tile, too.
  template <class Body>
  void ForEachBatch(std::span<const RayBlock> blocks, const Body& body) {
    const size_t row = std::max(1u, TileColumns(blocks));
    const size_t batch = std::max<size_t>(1, kRaysPerSubmit / kRaysPerBlock / row) * row;
    for (size_t first = 0; first < blocks.size(); first += batch) {
      body(blocks.subspan(first, std::min(batch, blocks.size() - first)));
    }
  }

  // Forward pass over blocks of the render view: colour and optical depth per ray.
  std::vector<glm::vec4> MarchBatch(std::span<const RayBlock> blocks) {
    RayBatch& rays = picture_rays_;
    PutBlocks(rays, blocks);
    has_forward_ = false;
    RayPass pass = RenderPass(blocks, {});
    pass.count_steps = options_.count_steps;
    render_recorder_.Begin();
    integrator_->Forward(render_recorder_, pass);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    // The device's 32-bit counters would overflow in images of many steps.
    AddCounters(counts_);
    counters_.FillZero();
    return rays.colors.DownloadAs<glm::vec4>(rays.count);
  }

  // Distances from the camera at which rays of the render view have lost half of their light; 0:
  // nowhere.
  std::vector<float> ReachesOfBatch(std::span<const RayBlock> blocks) {
    RayBatch& rays = picture_rays_;
    PutBlocks(rays, blocks);
    has_forward_ = false;
    RayPass pass = RenderPass(blocks, {});
    pass.push.stop_depth = float(kHalfLightDepth);
    const Buffer reaches(*device_, "ray reaches", uint64_t{rays.count} * 4);
    render_recorder_.Begin();
    march_.ForwardWithReaches(render_recorder_, pass, reaches);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    AddCounters(counts_);
    counters_.FillZero();
    return reaches.DownloadAs<float>(rays.count);
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

  RayPass RenderPass(std::span<const RayBlock> blocks, const FixedPoint& fixed) {
    return PassOver(picture_rays_, render_view_, blocks, gpu_render_view_, {}, fixed);
  }

  RayPass PassOver(RayBatch& rays, const Buffer& views, std::span<const RayBlock> blocks,
                   const GpuView& view, const TrainingBatch& batch, const FixedPoint& fixed) {
    return {field_,
            rays,
            views,
            blocks,
            view,
            counters_,
            RayPush{.ray_count = rays.count,
                    .jitter_seed = batch.seed,
                    .jitter_px = batch.jitter_px,
                    .stop_depth = -std::log(options_.stop_transmittance),
                    .color_quanta = fixed.color_quanta,
                    .density_quanta = fixed.density_quanta,
                    .position_quanta = fixed.position_quanta,
                    .largest_quanta = fixed.largest_quanta,
                    .first_cell = field_.first_cell}};
  }

  void RecordLoss(CommandRecorder& recorder, BatchSlot& slot, const TrainingBatch& batch,
                  const RayGradients& gradients) {
    const RayBatch& rays = slot.rays;
    const LossPush push{.ray_count = rays.count,
                        .loss = batch.loss == LossKind::kL2 ? uint32_t(kLossL2) : uint32_t(kLossL1),
                        .gradient_scale = gradients.scale,
                        .writes_residuals = gradients.are_residuals,
                        .background = glm::vec4(batch.background_srgb, 0.0f)};
    if (batch.sums_exposures) RecordExposureSums(recorder, slot, batch, push);
    slot.dssim.weight = batch.dssim_weight;
    if (batch.dssim_weight > 0) {
      CheckTiles(batch);
      if (!dssim_) dssim_ = std::make_unique<DssimLoss>(*device_);
      dssim_->Record(recorder, slot.dssim, rays, batch, push, training_views_, exposures_,
                     targets_);
      return;
    }
    recorder.Dispatch(loss_,
                      {{kBindViews, training_views_},
                       {kBindBlocks, rays.blocks},
                       {kBindRayColors, rays.colors},
                       {kBindRayGradients, rays.gradients},
                       {kBindPartialLosses, rays.partial_losses},
                       {kBindTargets, targets_},
                       {kBindExposures, exposures_}},
                      push, rays.count);
  }

  void RecordExposureSums(CommandRecorder& recorder, BatchSlot& slot, const TrainingBatch& batch,
                          const LossPush& push) {
    RayBatch& rays = slot.rays;
    Grow(*device_, rays.exposure_sums, "exposure sums",
         batch.blocks.size() * 4 * sizeof(glm::vec4));
    recorder.Dispatch(exposure_sums_,
                      {{kBindViews, training_views_},
                       {kBindBlocks, rays.blocks},
                       {kBindRayColors, rays.colors},
                       {kBindTargets, targets_},
                       {kBindExposureSums, rays.exposure_sums}},
                      push, batch.blocks.size());
    for (const RayBlock& block : batch.blocks) slot.uncollected_views.push_back(block.view);
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

  void RecordUpdate(CommandRecorder& recorder, const AdamUpdate& update, const FixedPoint& fixed) {
    AdamPush push = MakeAdamPush(update, field_.row_count);
    push.quanta[kRateColor] = 1.0f / fixed.color_quanta;
    push.quanta[kRateDensity] = 1.0f / fixed.density_quanta;
    push.first_cell = field_.first_cell;
    recorder.DispatchMany(adam_,
                          {{kBindVertexGradients, field_.gradients},
                           {kBindParameters, field_.parameters},
                           {kBindMoments, field_.moments},
                           {kBindRateShares, field_.rate_shares},
                           {kBindVertices, field_.vertices}},
                          push, field_.row_count);
  }

  RendererOptions options_;
  std::unique_ptr<Device> device_;
  FieldLayout layout_;  // which the kernels below are made for
  Program loss_, exposure_sums_, adam_, spread_;
  MarchIntegrator march_;              // for scores, whichever integrator renders
  std::unique_ptr<Integrator> other_;  // unless the march renders
  Integrator* integrator_;
  std::array<std::unique_ptr<CommandRecorder>, 2> recorders_;
  CommandRecorder render_recorder_;
  Buffer counters_, render_view_;
  DeviceField field_;
  Buffer targets_, training_views_;
  Buffer exposures_;  // of the training views
  size_t exposed_views_ = 0;
  std::vector<BlockExposureSums> block_sums_;  // since AddExposureSums
  std::vector<RenderView> views_;
  std::vector<GpuView> gpu_views_;  // as in training_views_
  GpuView gpu_render_view_;         // as in render_view_
  std::vector<uint32_t> first_pixels_;
  std::array<BatchSlot, 2> in_flight_;  // of steps and scores
  RayBatch picture_rays_;               // apart: the losses of steps are read late
  BatchSlot part_;                      // for Forward and Backward
  TrainingBatch forward_batch_;         // that of the last Forward, with
  std::vector<RayBlock> forward_blocks_;
  bool has_forward_ = false;        // and nothing was rendered since
  bool has_sums_ = false;           // gradients that no update has used
  bool has_position_sums_ = false;  // nor was taken
  bool has_quanta_ = false;         // sums_fixed_ is known since the last update
  FixedPoint sums_fixed_;
  std::unique_ptr<DssimLoss> dssim_;  // once a batch needs it
  int current_ = 0;
  uint64_t scored_rays_ = 0;  // since ClearScores
  RenderCounts counts_;       // without those still in counters_
};

}  // namespace

std::unique_ptr<ProbedRenderer> CreateVulkanRenderer(const RendererOptions& options) {
  return std::make_unique<VulkanRenderer>(options);
}

}  // namespace tetrec
