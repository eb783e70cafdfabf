// The default renderer: marches from tet to tet on Vulkan compute, forward and backward.
#include "core/error.h"
#include "mesh/locate.h"
#include "render/march_gpu.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

using gpu_types::AdamPush;
using gpu_types::GpuBlock;
using gpu_types::GpuView;
using gpu_types::LossPush;
using gpu_types::MarchPush;
using gpu_types::Moments;

static_assert(sizeof(RayBlock) == sizeof(GpuBlock));
static_assert(kRayBlockWidth == kBlockWidth && kRayBlockHeight == kBlockHeight);

// Rays of one submit while rendering pictures; bounds the ray buffers.
constexpr uint32_t kRaysPerSubmit = 1u << 17;

// What lives on the device for a batch of rays.
struct RayBuffers {
  Buffer blocks, colors, entries, gradients, partial_losses;
  uint32_t capacity = 0;  // rays

  void Reserve(const Device& device, uint32_t rays) {
    if (rays <= capacity) return;
    blocks = Buffer(device, "ray blocks", uint64_t(rays / kBlockRays) * sizeof(GpuBlock));
    colors = Buffer(device, "ray colors", uint64_t(rays) * 16);
    entries = Buffer(device, "ray entries", uint64_t(rays) * 8);
    gradients = Buffer(device, "ray gradients", uint64_t(rays) * 16);
    partial_losses =
        Buffer(device, "partial losses", uint64_t(rays + kWorkgroupSize - 1) / kWorkgroupSize * 8);
    capacity = rays;
  }
};

// 4 x 2 blocks that cover width x height, row of blocks by row.
std::vector<RayBlock> CoveringBlocks(int width, int height) {
  std::vector<RayBlock> blocks;
  for (int y = 0; y < height; y += kBlockHeight) {
    for (int x = 0; x < width; x += kBlockWidth) blocks.push_back({0, uint32_t(x), uint32_t(y)});
  }
  return blocks;
}

class MarchRenderer final : public TrainingRenderer {
 public:
  explicit MarchRenderer(const RendererOptions& options)
      : options_(options),
        device_(CreateDevice(options.device)),
        programs_(CreateMarchPrograms(*device_)),
        recorders_{std::make_unique<CommandRecorder>(*device_),
                   std::make_unique<CommandRecorder>(*device_)},
        render_recorder_(*device_),
        counters_(*device_, "counters", kCounterCount * 4),
        render_view_(*device_, "view", sizeof(GpuView)) {
    counters_.FillZero();
  }

  // Buffers go before the recorders; the device must be done with them.
  ~MarchRenderer() override { WaitAll(); }

  void SetField(const RadianceField& field) override {
    SetVertexState(field.mesh, {ParametersOf(field), {}, {}});
  }

  void SetVertexState(const TetMesh& mesh, const VertexState& state) override {
    WaitAll();
    mesh_ = mesh;
    march_mesh_ = UploadMesh(*device_, mesh, state.parameters);
    parameters_ = MakeBuffer(*device_, "parameters", state.parameters);
    std::vector<Moments> moments(state.parameters.size());
    for (size_t v = 0; v < state.first_moment.size(); ++v) {
      moments[v] = {state.first_moment[v], state.second_moment[v]};
    }
    moments_ = MakeBuffer(*device_, "moments", moments);
    gradients_ = Buffer(*device_, "vertex gradients", uint64_t(march_mesh_.vertex_count) * 16);
    gradients_.FillZero();
    tet_scores_ = Buffer(*device_, "tet scores", uint64_t(march_mesh_.tet_count) * 4);
    tet_scores_.FillZero();
    UploadViews();
  }

  VertexState ReadVertexState() override {
    WaitAll();
    const uint32_t count = march_mesh_.vertex_count;
    VertexState state;
    state.parameters = parameters_.DownloadAs<glm::vec4>(count);
    state.first_moment.resize(count);
    state.second_moment.resize(count);
    const std::vector<Moments> moments = moments_.DownloadAs<Moments>(count);
    for (uint32_t v = 0; v < count; ++v) {
      state.first_moment[v] = moments[v].first;
      state.second_moment[v] = moments[v].second;
    }
    return state;
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
    if (march_mesh_.tet_count > 0) UploadViews();
  }

  // Two steps are in flight: while the device works on one, the host prepares the next.
  StepResult Step(const TrainingStep& step) override {
    current_ ^= 1;
    const StepResult before = Collect(current_);
    RayBuffers& rays = rays_[current_];
    const uint32_t count = PutBlocks(rays, step.blocks);
    CommandRecorder& recorder = *recorders_[current_];
    recorder.Begin();
    RecordForward(recorder, programs_.forward, rays, training_views_, MarchPushFor(step, count));
    RecordLoss(recorder, rays, step, count, 1.0f / float(3 * count));
    RecordBackward(recorder, rays, training_views_, MarchPushFor(step, count));
    RecordAdam(recorder, step);
    recorder.EndAndSubmit();
    in_flight_[current_] = {count, step.loss};
    return before;
  }

  void ClearScores() override {
    WaitAll();
    tet_scores_.FillZero();
  }

  StepResult AddScores(const TrainingStep& step) override {
    current_ ^= 1;
    const StepResult before = Collect(current_);
    RayBuffers& rays = rays_[current_];
    const uint32_t count = PutBlocks(rays, step.blocks);
    CommandRecorder& recorder = *recorders_[current_];
    const MarchPush push = MarchPushFor(step, count);
    recorder.Begin();
    RecordForward(recorder, programs_.forward, rays, training_views_, push);
    RecordLoss(recorder, rays, step, count, 0.5f);
    const Buffer* buffers[] = {&march_mesh_.tets, &march_mesh_.vertices, &march_mesh_.hull,
                               &training_views_,  &rays.blocks,          &counters_,
                               &rays.entries,     &rays.gradients,       &tet_scores_};
    recorder.Dispatch(programs_.score, buffers, push, count, kWorkgroupSize);
    recorder.EndAndSubmit();
    in_flight_[current_] = {count, step.loss};
    return before;
  }

  std::vector<float> ReadScores() override {
    WaitAll();
    return tet_scores_.DownloadAs<float>(march_mesh_.tet_count);
  }

  RenderedImage Render(const RenderView& view, int samples) override {
    WaitAll();
    const int width = view.camera.width, height = view.camera.height;
    UploadRenderView(view, samples);
    RenderedImage image{width, height, std::vector<glm::vec3>(size_t(width) * height),
                        std::vector<float>(size_t(width) * height)};
    const float share = 1.0f / float(samples * samples);
    ForEachBatch(width * samples, height * samples, [&](std::span<const RayBlock> blocks) {
      const std::vector<glm::vec4> colors = MarchBatch(blocks);
      for (size_t r = 0; r < colors.size(); ++r) {
        const RayBlock& block = blocks[r / kBlockRays];
        const int x = int(block.x + r % kBlockWidth),
                  y = int(block.y + r % kBlockRays / kBlockWidth);
        if (x >= width * samples || y >= height * samples) continue;
        const size_t pixel = size_t(y / samples) * width + x / samples;
        image.color_srgb[pixel] += share * glm::vec3(colors[r]);
        image.transmittance[pixel] += share * std::exp(-colors[r].a);
      }
    });
    return image;
  }

  FieldGradient Backpropagate(const RenderView& view,
                              std::span<const glm::vec4> pixel_gradient) override {
    WaitAll();
    const int width = view.camera.width, height = view.camera.height;
    TETREC_CHECK(pixel_gradient.size() == size_t(width) * height, "one gradient a pixel");
    UploadRenderView(view, 1);
    gradients_.FillZero();
    ForEachBatch(width, height, [&](std::span<const RayBlock> blocks) {
      MarchBatch(blocks);
      std::vector<glm::vec4> gradients(blocks.size() * kBlockRays, glm::vec4(0.0f));
      for (size_t r = 0; r < gradients.size(); ++r) {
        const RayBlock& block = blocks[r / kBlockRays];
        const int x = int(block.x + r % kBlockWidth),
                  y = int(block.y + r % kBlockRays / kBlockWidth);
        if (x < width && y < height) gradients[r] = pixel_gradient[size_t(y) * width + x];
      }
      RayBuffers& rays = rays_[0];
      rays.gradients.Upload(gradients);
      render_recorder_.Begin();
      RecordBackward(render_recorder_, rays, render_view_,
                     MarchPushFor({}, uint32_t(gradients.size())));
      render_recorder_.EndAndSubmit();
      render_recorder_.Wait();
    });
    FieldGradient result;
    for (const glm::vec4& g : gradients_.DownloadAs<glm::vec4>(march_mesh_.vertex_count)) {
      result.color_srgb.emplace_back(g);
      result.density.push_back(g.a);
    }
    gradients_.FillZero();
    return result;
  }

  std::vector<glm::vec4> MarchBlocks(const RenderView& view,
                                     std::span<const RayBlock> blocks) override {
    WaitAll();
    UploadRenderView(view, 1);
    return MarchBatch(blocks);
  }

  RenderCounts counts() const override {
    WaitAll();
    RenderCounts counts = counts_;
    AddCounters(counts);
    return counts;
  }

  std::vector<std::string> ValidationMessages() const override {
    return device_->validation_messages;
  }

  nlohmann::json DescribeDevice() const override { return tetrec::DescribeDevice(*device_); }

 private:
  struct InFlight {
    uint32_t rays = 0;
    LossKind loss = LossKind::kL2;
  };

  void WaitAll() const {
    for (const auto& recorder : recorders_) recorder->Wait();
  }

  void AddCounters(RenderCounts& counts) const {
    const auto counters = counters_.DownloadAs<uint32_t>(kCounterCount);
    counts.lost_rays += counters[kCounterLostRays];
    counts.hit_rays += counters[kCounterHitRays];
    counts.steps += counters[kCounterSteps];
  }

  // Waits for the batch in slot `i` and sums its losses.
  StepResult Collect(int i) {
    recorders_[i]->Wait();
    const InFlight done = std::exchange(in_flight_[i], {});
    StepResult result;
    if (done.rays == 0) return result;
    const uint32_t groups = (done.rays + kWorkgroupSize - 1) / kWorkgroupSize;
    for (const glm::vec2& partial : rays_[i].partial_losses.DownloadAs<glm::vec2>(groups)) {
      result.loss += partial.x;
      result.squared_error += partial.y;
    }
    result.loss /= 3.0 * done.rays;
    result.squared_error /= 3.0 * done.rays;
    return result;
  }

  void UploadViews() {
    std::vector<GpuView> views;
    uint32_t tet = 0;
    for (size_t i = 0; i < views_.size(); ++i) {
      tet = FindTet(mesh_, views_[i].cam_from_world.Inverse().translation, tet == kNoTet ? 0 : tet);
      views.push_back(MakeGpuView(views_[i], 1, first_pixels_[i], tet));
    }
    training_views_ = MakeBuffer(*device_, "views", views);
  }

  void UploadRenderView(const RenderView& view, int samples) {
    const uint32_t tet = FindTet(mesh_, view.cam_from_world.Inverse().translation);
    const GpuView gpu_view = MakeGpuView(view, samples, 0, tet);
    render_view_.Upload(&gpu_view, sizeof(gpu_view));
  }

  uint32_t PutBlocks(RayBuffers& rays, std::span<const RayBlock> blocks) {
    const uint32_t count = uint32_t(blocks.size()) * kBlockRays;
    rays.Reserve(*device_, count);
    rays.blocks.Upload(blocks.data(), blocks.size_bytes());
    counts_.rays += count;
    return count;
  }

  template <class Body>
  void ForEachBatch(int width, int height, const Body& body) {
    const std::vector<RayBlock> blocks = CoveringBlocks(width, height);
    constexpr size_t kBatch = kRaysPerSubmit / kBlockRays;
    for (size_t first = 0; first < blocks.size(); first += kBatch) {
      body(std::span(blocks).subspan(first, std::min(kBatch, blocks.size() - first)));
    }
  }

  // Forward march of blocks of the render view: colour and optical depth a ray.
  std::vector<glm::vec4> MarchBatch(std::span<const RayBlock> blocks) {
    RayBuffers& rays = rays_[0];
    const uint32_t count = PutBlocks(rays, blocks);
    render_recorder_.Begin();
    RecordForward(render_recorder_,
                  options_.count_steps ? programs_.forward_counting : programs_.forward, rays,
                  render_view_, MarchPushFor({}, count));
    render_recorder_.EndAndSubmit();
    render_recorder_.Wait();
    // The device's 32-bit counters would run over in pictures of many steps.
    AddCounters(counts_);
    counters_.FillZero();
    return rays.colors.DownloadAs<glm::vec4>(count);
  }

  MarchPush MarchPushFor(const TrainingStep& step, uint32_t count) const {
    return {.ray_count = count,
            .hull_faces = march_mesh_.hull_faces,
            .max_steps = options_.max_steps,
            .jitter_seed = step.seed,
            .jitter_px = step.jitter_px,
            .stop_depth = -std::log(options_.stop_transmittance)};
  }

  void RecordForward(CommandRecorder& recorder, const Program& program, const RayBuffers& rays,
                     const Buffer& views, const MarchPush& push) {
    const Buffer* buffers[] = {
        &march_mesh_.tets, &march_mesh_.vertices, &march_mesh_.hull, &views, &rays.blocks,
        &counters_,        &rays.colors,          &rays.entries};
    recorder.Dispatch(program, buffers, push, push.ray_count, kWorkgroupSize);
  }

  void RecordLoss(CommandRecorder& recorder, const RayBuffers& rays, const TrainingStep& step,
                  uint32_t count, float gradient_scale) {
    const LossPush push{.ray_count = count,
                        .loss = step.loss == LossKind::kL2 ? uint32_t(kLossL2) : uint32_t(kLossL1),
                        .gradient_scale = gradient_scale,
                        .background = glm::vec4(step.background_srgb, 0.0f)};
    const Buffer* buffers[] = {&training_views_, &rays.blocks,         &rays.colors,
                               &rays.gradients,  &rays.partial_losses, &targets_};
    recorder.Dispatch(programs_.loss, buffers, push, count, kWorkgroupSize);
  }

  void RecordBackward(CommandRecorder& recorder, const RayBuffers& rays, const Buffer& views,
                      const MarchPush& push) {
    const Buffer* buffers[] = {
        &march_mesh_.tets, &march_mesh_.vertices, &march_mesh_.hull, &views,          &rays.blocks,
        &counters_,        &rays.colors,          &rays.entries,     &rays.gradients, &gradients_};
    recorder.Dispatch(programs_.backward, buffers, push, push.ray_count, kWorkgroupSize);
  }

  void RecordAdam(CommandRecorder& recorder, const TrainingStep& step) {
    const AdamOptions& adam = step.adam;
    const double t = step.adam_step;
    const float first_correction = float(1.0 / (1.0 - std::pow(double(adam.beta1), t)));
    const AdamPush push{
        .vertex_count = march_mesh_.vertex_count,
        .beta1 = adam.beta1,
        .beta2 = adam.beta2,
        .epsilon = adam.epsilon,
        .color_rate = adam.color_rate * first_correction,
        .density_rate = adam.density_rate * first_correction,
        .second_moment_correction = float(1.0 / (1.0 - std::pow(double(adam.beta2), t))),
        .max_log_density = std::log(adam.max_density)};
    const Buffer* buffers[] = {&gradients_, &parameters_, &moments_, &march_mesh_.vertices};
    recorder.Dispatch(programs_.adam, buffers, push, march_mesh_.vertex_count, kWorkgroupSize);
  }

  RendererOptions options_;
  std::unique_ptr<Device> device_;
  MarchPrograms programs_;
  std::array<std::unique_ptr<CommandRecorder>, 2> recorders_;
  CommandRecorder render_recorder_;
  Buffer counters_, render_view_;
  TetMesh mesh_;
  MarchMesh march_mesh_;
  Buffer parameters_, moments_, gradients_, tet_scores_, targets_, training_views_;
  std::vector<RenderView> views_;
  std::vector<uint32_t> first_pixels_;
  std::array<RayBuffers, 2> rays_;
  std::array<InFlight, 2> in_flight_;
  int current_ = 0;
  RenderCounts counts_;  // without what is still in counters_
};

}  // namespace

std::unique_ptr<TrainingRenderer> CreateMarchRenderer(const RendererOptions& options) {
  return std::make_unique<MarchRenderer>(options);
}

}  // namespace tetrec
