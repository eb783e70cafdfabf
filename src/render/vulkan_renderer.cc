// Renderers on Vulkan compute: pictures, gradients, training steps over any integrator.
#include "render/vulkan_renderer.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "mesh/locate.h"
#include "render/adam_push.h"
#include "render/dssim_loss.h"
#include "render/field_checks.h"
#include "render/fixed_point.h"
#include "render/march_integrator.h"
#include "render/ppll_integrator.h"
#include "render/projection_integrator.h"
#include "render/ray_blocks.h"
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
using gpu_types::MarchPush;
using gpu_types::SpreadPush;

// Rays of one submit while rendering pictures; bounds the ray buffers, the workgroups of a dispatch
// and what the device's 32-bit counters must hold.
constexpr uint32_t kRaysPerSubmit = 1u << 17;

// `grid` rays a pixel side; `start_tet` as FindTet gives it.
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

Program LossProgram(const Device& device) {
  return Program(device, "loss", kLoss,
                 {{kBindViews, Access::kTexelRead},
                  {kBindBlocks, Access::kTexelRead},
                  {kBindRayColors, Access::kRead},
                  {kBindRayGradients, Access::kWrite},
                  {kBindPartialLosses, Access::kWrite},
                  {kBindTargets, Access::kTexelRead}},
                 sizeof(LossPush));
}

Program AdamProgram(const Device& device, FieldStorage storage, bool fixed_point) {
  const SpecializationConstant constants[] = {ConstantOf(storage)};
  const std::span<const uint32_t> fixed = kAdamFixed, floats = kAdam;
  return Program(device, "adam", fixed_point ? fixed : floats,
                 {{kBindVertexGradients, Access::kReadWrite},
                  {kBindParameters, Access::kReadWrite},
                  {kBindMoments, Access::kReadWrite},
                  {kBindVertices, Access::kReadWrite}},
                 sizeof(AdamPush), constants);
}

Program SpreadProgram(const Device& device, FieldStorage storage) {
  const SpecializationConstant constants[] = {ConstantOf(storage)};
  return Program(device, "spread", kSpread,
                 {{kBindParameters, Access::kRead}, {kBindVertices, Access::kReadWrite}},
                 sizeof(SpreadPush), constants);
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

// Tets on one ray that the device's kernels can walk: a step's own loops and those of rare
// branches, the parts of a split segment, and what sums take, in fixed point or by compare and
// swap.
uint32_t LongestWalk(const Device& device, const RendererOptions& options) {
  const bool is_split = options.integral.kind == IntegralKind::kSplit;
  const uint32_t sums = options.deterministic ? 8 : device.has_float_atomics ? 0 : 72;
  return MostLoopRounds(device) / (6 + (is_split ? uint32_t(options.integral.splits) : 0) + sums);
}

// Null for the march.
std::unique_ptr<Integrator> MakeOtherIntegrator(const Device& device,
                                                const RendererOptions& options,
                                                FieldStorage storage) {
  if (options.kind == RendererKind::kPpll) {
    return std::make_unique<PpllIntegrator>(device, options, storage);
  }
  if (options.kind == RendererKind::kProjection) {
    return std::make_unique<ProjectionIntegrator>(device, options, storage);
  }
  return nullptr;
}

class VulkanRenderer final : public TrainingRenderer {
 public:
  explicit VulkanRenderer(const RendererOptions& options)
      : options_(options),
        device_(CreateDevice(DeviceOptionsOf(options))),
        loss_(LossProgram(*device_)),
        adam_(AdamProgram(*device_, storage_, options.deterministic)),
        spread_(SpreadProgram(*device_, storage_)),
        march_(*device_, options.integral, options.deterministic),
        other_(MakeOtherIntegrator(*device_, options, storage_)),
        integrator_(other_ ? other_.get() : &march_),
        recorders_{std::make_unique<CommandRecorder>(*device_),
                   std::make_unique<CommandRecorder>(*device_)},
        render_recorder_(*device_),
        counters_(*device_, "counters", kCounterCount * 4),
        render_view_(*device_, "view", sizeof(GpuView), VK_FORMAT_R32G32B32A32_UINT) {
    counters_.FillZero();
  }

  // Buffers go before the recorders; the device must be done with them.
  ~VulkanRenderer() override { WaitAll(); }

  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetVertexState(field.mesh, {ParametersOf(field), {}, {}, field.storage});
  }

  void SetVertexState(const TetMesh& mesh, const VertexState& state) override {
    CheckRenderable(mesh, state);
    integrator_->CheckMesh(mesh);
    WaitAll();
    FreeMemory free = MeasureFreeMemory(*device_);
    if (field_.tet_count > 0)
      free.bytes += FieldBytes(field_.mesh, storage_, options_.deterministic);
    CheckMemory(mesh, BytesFor(mesh, state.storage), free);
    field_ = {};  // frees the old mesh before the new one takes memory
    UseStorage(state.storage);
    field_ = UploadField(*device_, mesh, state, options_.deterministic);
    render_recorder_.Begin();
    const Buffer* buffers[] = {&field_.parameters, &field_.vertices};
    render_recorder_.DispatchMany(spread_, buffers, SpreadPush{field_.row_count, field_.first_cell},
                                  field_.row_count, kWorkgroupSize);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    march_.SetField(field_);
    if (other_) other_->SetField(field_);
    UploadViews();
  }

  VertexState ReadVertexState() override {
    WaitAll();
    return DownloadState(field_);
  }

  void SetTargets(std::span<const RenderView> views,
                  std::span<const TargetImage> targets) override {
    TETREC_CHECK(views.size() == targets.size(), "one target a view");
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
    if (field_.tet_count > 0) UploadViews();
  }

  // Two steps are in flight: while the device works on one, the host prepares the next.
  StepResult Step(const TrainingStep& step) override {
    const uint64_t rays = step.blocks.size() * kRaysPerBlock;
    const float gradient_scale = 1.0f / float(3 * rays);
    const FixedPoint fixed = FixedPointOf(GradientScale(step), rays);
    return InFlightBatch(*integrator_, step, gradient_scale, fixed,
                         [&](CommandRecorder& recorder, const RayPass& pass) {
                           integrator_->Backward(recorder, pass);
                           RecordAdam(recorder, step, fixed);
                         });
  }

  bool NeedsTiles() const override { return integrator_ != &march_; }

  void ClearScores() override {
    WaitAll();
    field_.tet_scores.FillZero();
    scored_rays_ = 0;
  }

  // A gradient scale of 1/2 leaves the residuals themselves in the rays' gradients.
  StepResult AddScores(const TrainingStep& step) override {
    scored_rays_ += step.blocks.size() * kRaysPerBlock;
    TETREC_CHECK(!options_.deterministic || scored_rays_ <= kMostScoredRays,
                 fmt::format("scores of {} rays: their fixed-point sums hold {}", scored_rays_,
                             kMostScoredRays));
    FixedPoint fixed;
    fixed.largest_quanta = float(kLargestScore * kScoreQuanta);
    return InFlightBatch(
        march_, step, 0.5f, fixed,
        [&](CommandRecorder& recorder, const RayPass& pass) { march_.Score(recorder, pass); });
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

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    WaitAll();
    const int width = view.camera.width, height = view.camera.height;
    TETREC_CHECK(pixel_gradient.size() == size_t(width) * height, "one gradient a pixel");
    UploadRenderView(view, 1);
    const FixedPoint fixed = FixedPointOf(LargestValue(pixel_gradient), pixel_gradient.size());
    field_.gradients.FillZero();
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
    FieldGradient result;
    for (const glm::vec4& g : DownloadRowSums(field_, field_.gradients, field_.row_count,
                                              {fixed.color_quanta, fixed.density_quanta})) {
      result.color_srgb.emplace_back(g);
      result.density.push_back(g.a);
    }
    field_.gradients.FillZero();
    if (!with_positions) return result;
    for (const glm::vec4& g :
         DownloadRowSums(field_, field_.position_gradients, field_.vertex_count,
                         glm::dvec2(fixed.position_quanta))) {
      result.position.emplace_back(g);
      result.absolute_position.push_back(g.a);
    }
    field_.position_gradients.FillZero();
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
  // At most. On a software device the host's copies count, too.
  uint64_t BytesFor(const TetMesh& mesh, FieldStorage storage) const {
    const uint64_t on_device = FieldBytes(mesh, storage, options_.deterministic) +
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
  void UseStorage(FieldStorage storage) {
    if (storage == storage_) return;
    storage_ = storage;
    adam_ = AdamProgram(*device_, storage, options_.deterministic);
    spread_ = SpreadProgram(*device_, storage);
    other_ = MakeOtherIntegrator(*device_, options_, storage);
    integrator_ = other_ ? other_.get() : &march_;
  }

  void AddCounters(RenderCounts& counts) const {
    const auto counters = counters_.DownloadAs<uint32_t>(kCounterCount);
    counts.lost_rays += counters[kCounterLostRays];
    counts.clamped_addends += counters[kCounterClamped];
    counts.hit_rays += counters[kCounterHitRays];
    counts.steps += counters[kCounterSteps];
  }

  // Forward and loss of a batch, then what `then` records; the losses of the batch before last.
  template <class Then>
  StepResult InFlightBatch(Integrator& integrator, const TrainingStep& step, float gradient_scale,
                           const FixedPoint& fixed, const Then& then) {
    current_ ^= 1;
    const StepResult before = Collect(current_);
    RayBatch& rays = rays_[current_];
    PutBlocks(rays, step.blocks);
    const RayPass pass =
        PassOver(rays, training_views_, step.blocks, gpu_views_[step.blocks[0].view], step, fixed);
    CommandRecorder& recorder = *recorders_[current_];
    recorder.Begin();
    integrator.Forward(recorder, pass);
    RecordLoss(recorder, step, gradient_scale);
    then(recorder, pass);
    recorder.EndAndSubmit();
    in_flight_rays_[current_] = rays.count;
    return before;
  }

  // Waits for the batch in slot `i` and sums its losses.
  StepResult Collect(int i) {
    recorders_[i]->Wait();
    const uint32_t rays = std::exchange(in_flight_rays_[i], 0);
    StepResult result;
    if (rays == 0) return result;
    const uint32_t groups = (rays + kWorkgroupSize - 1) / kWorkgroupSize;
    for (const glm::vec2& partial : rays_[i].partial_losses.DownloadAs<glm::vec2>(groups)) {
      result.loss += partial.x;
      result.squared_error += partial.y;
    }
    result.loss = dssim_batches_[i].Mix(result.loss / (3.0 * rays));
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

  // Batches of a tile are whole rows of its blocks, so that each is a tile.
  template <class Body>
  void ForEachBatch(std::span<const RayBlock> blocks, const Body& body) {
    const size_t row = std::max(1u, TileColumns(blocks));
    const size_t batch = std::max<size_t>(1, kRaysPerSubmit / kRaysPerBlock / row) * row;
    for (size_t first = 0; first < blocks.size(); first += batch) {
      body(blocks.subspan(first, std::min(batch, blocks.size() - first)));
    }
  }

  // Forward march of blocks of the render view: colour and optical depth a ray.
  std::vector<glm::vec4> MarchBatch(std::span<const RayBlock> blocks) {
    RayBatch& rays = picture_rays_;
    PutBlocks(rays, blocks);
    RayPass pass = RenderPass(blocks, {});
    pass.count_steps = options_.count_steps;
    render_recorder_.Begin();
    integrator_->Forward(render_recorder_, pass);
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    // The device's 32-bit counters would run over in pictures of many steps.
    AddCounters(counts_);
    counters_.FillZero();
    return rays.colors.DownloadAs<glm::vec4>(rays.count);
  }

  FixedPoint FixedPointOf(double gradient_scale, uint64_t rays) const {
    if (!options_.deterministic) return {};
    return ChooseFixedPoint(gradient_scale, rays, field_.most_tets_at_vertex, field_.diagonal);
  }

  RayPass RenderPass(std::span<const RayBlock> blocks, const FixedPoint& fixed) {
    return PassOver(picture_rays_, render_view_, blocks, gpu_render_view_, {}, fixed);
  }

  RayPass PassOver(RayBatch& rays, const Buffer& views, std::span<const RayBlock> blocks,
                   const GpuView& view, const TrainingStep& step, const FixedPoint& fixed) {
    return {field_,
            rays,
            views,
            blocks,
            view,
            counters_,
            MarchPush{.mesh_ball = field_.ball,
                      .ray_count = rays.count,
                      .hull_faces = field_.hull_faces,
                      .hull_planes = field_.hull_planes,
                      .tree_leaves = field_.tree_leaves,
                      .max_steps = std::min(options_.max_steps, LongestWalk(*device_, options_)),
                      .jitter_seed = step.seed,
                      .jitter_px = step.jitter_px,
                      .stop_depth = -std::log(options_.stop_transmittance),
                      .color_quanta = fixed.color_quanta,
                      .density_quanta = fixed.density_quanta,
                      .position_quanta = fixed.position_quanta,
                      .largest_quanta = fixed.largest_quanta,
                      .first_cell = field_.first_cell}};
  }

  void RecordLoss(CommandRecorder& recorder, const TrainingStep& step, float gradient_scale) {
    const RayBatch& rays = rays_[current_];
    DssimBatch& dssim_batch = dssim_batches_[current_];
    const LossPush push{.ray_count = rays.count,
                        .loss = step.loss == LossKind::kL2 ? uint32_t(kLossL2) : uint32_t(kLossL1),
                        .gradient_scale = gradient_scale,
                        .background = glm::vec4(step.background_srgb, 0.0f)};
    dssim_batch.weight = step.dssim_weight;
    if (step.dssim_weight > 0) {
      CheckTiles(step);
      if (!dssim_) dssim_ = std::make_unique<DssimLoss>(*device_);
      dssim_->Record(recorder, dssim_batch, rays, step, push, training_views_, targets_);
      return;
    }
    const Buffer* buffers[] = {&training_views_, &rays.blocks,         &rays.colors,
                               &rays.gradients,  &rays.partial_losses, &targets_};
    recorder.Dispatch(loss_, buffers, push, rays.count, kWorkgroupSize);
  }

  // Windows must not reach beyond a picture, where rays have no target.
  void CheckTiles(const TrainingStep& step) const {
    for (const RayBlock& block : step.blocks) {
      const Camera& camera = views_[block.view].camera;
      TETREC_CHECK(int(block.x) + kRayBlockWidth <= camera.width &&
                       int(block.y) + kRayBlockHeight <= camera.height,
                   "a tile of D-SSIM leaves its picture");
    }
  }

  void RecordAdam(CommandRecorder& recorder, const TrainingStep& step, const FixedPoint& fixed) {
    AdamPush push = MakeAdamPush(step, field_.row_count);
    push.color_quantum = 1.0f / fixed.color_quanta;
    push.density_quantum = 1.0f / fixed.density_quanta;
    push.first_cell = field_.first_cell;
    const Buffer* buffers[] = {&field_.gradients, &field_.parameters, &field_.moments,
                               &field_.vertices};
    recorder.DispatchMany(adam_, buffers, push, field_.row_count, kWorkgroupSize);
  }

  RendererOptions options_;
  std::unique_ptr<Device> device_;
  FieldStorage storage_ = FieldStorage::kVertex;  // for which the kernels below are
  Program loss_, adam_, spread_;
  MarchIntegrator march_;              // scores, whatever renders
  std::unique_ptr<Integrator> other_;  // where the march does not render
  Integrator* integrator_;
  std::array<std::unique_ptr<CommandRecorder>, 2> recorders_;
  CommandRecorder render_recorder_;
  Buffer counters_, render_view_;
  DeviceField field_;
  Buffer targets_, training_views_;
  std::vector<RenderView> views_;
  std::vector<GpuView> gpu_views_;  // as in training_views_
  GpuView gpu_render_view_;         // as in render_view_
  std::vector<uint32_t> first_pixels_;
  std::array<RayBatch, 2> rays_;  // of steps
  RayBatch picture_rays_;         // their own: the losses of steps are read late
  std::array<uint32_t, 2> in_flight_rays_{};
  std::unique_ptr<DssimLoss> dssim_;  // once a step asks for it
  std::array<DssimBatch, 2> dssim_batches_;
  int current_ = 0;
  uint64_t scored_rays_ = 0;  // since ClearScores
  RenderCounts counts_;       // without what is still in counters_
};

}  // namespace

std::unique_ptr<TrainingRenderer> CreateVulkanRenderer(const RendererOptions& options) {
  return std::make_unique<VulkanRenderer>(options);
}

}  // namespace tetrec
