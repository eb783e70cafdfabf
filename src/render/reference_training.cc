// The reference renderer behind the interface of the others: pictures, gradients, training steps on
// the CPU.
#include "core/error.h"
#include "render/adam_push.h"
#include "render/dssim.h"
#include "render/field_checks.h"
#include "render/ray_blocks.h"
#include "render/reference_batch.h"
#include "shared/adam.glsl.h"
#include "shared/loss.glsl.h"
#include "shared/random.glsl.h"
#include "shared/ssim.glsl.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <thread>

namespace tetrec {
namespace {

// What a field takes: the mesh with its boxes and scores, and parameters, moments and gradients.
constexpr uint64_t kBytesPerTet = 100, kBytesPerRow = 200;

template <class Real>
class ReferenceRenderer final : public TrainingRenderer {
 public:
  explicit ReferenceRenderer(const RendererOptions& options)
      : options_(options), stop_depth_(StopDepthOf<Real>(options.stop_transmittance)) {}

  // The field's own densities: no way there and back through logarithms.
  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetVertexState(field.mesh, {ParametersOf(field), {}, {}, field.storage});
    field_ = field;
  }

  void SetVertexState(const TetMesh& mesh, const VertexState& state) override {
    CheckRenderable(mesh, state);
    const size_t rows = RowCount(mesh, state.storage);
    CheckMemory(mesh, kBytesPerTet * mesh.tets.size() + kBytesPerRow * rows,
                MeasureFreeHostMemory());
    state_ = state;
    state_.first_moment.resize(rows, glm::vec4(0.0f));
    state_.second_moment.resize(rows, glm::vec4(0.0f));
    field_ = {mesh, std::vector<float>(rows), std::vector<glm::vec3>(rows), state.storage};
    for (size_t row = 0; row < rows; ++row) Spread(row);
    boxes_ = MakeTetBoxes(mesh);
    scores_.assign(mesh.tets.size(), 0.0);
  }

  VertexState ReadVertexState() override { return state_; }

  void SetTargets(std::span<const RenderView> views,
                  std::span<const TargetImage> targets) override {
    TETREC_CHECK(views.size() == targets.size(), "one target a view");
    for (size_t i = 0; i < views.size(); ++i) {
      TETREC_CHECK(
          views[i].camera.width == targets[i].width && views[i].camera.height == targets[i].height,
          fmt::format("target {} and its camera differ in size", i));
    }
    views_.assign(views.begin(), views.end());
    targets_.assign(targets.begin(), targets.end());
  }

  bool NeedsTiles() const override { return false; }

  StepResult Step(const TrainingStep& step) override {
    const Batch batch{views_, step.blocks, step.jitter_px, step.seed};
    std::vector<Vec4<Real>> gradients(batch.rays());
    const std::vector<Vec4<Real>> colors = March(batch);
    StepResult result =
        CompareWithTargets(batch, colors, step, Real(1) / Real(3 * batch.rays()), gradients);
    if (step.dssim_weight > 0) MixDssim(batch, colors, step, gradients, result);
    ReferenceGradient sum(field_);
    AddGradients<Real>(
        field_, boxes_, batch.rays(), [&](size_t i) { return RayOf(batch, i); },
        [&](size_t i) { return gradients[i]; }, stop_depth_, options_.integral, false, sum);
    TakeAdamStep(step, sum);
    return OneStepLate(result);
  }

  void ClearScores() override { scores_.assign(scores_.size(), 0.0); }

  // A gradient scale of 1/2 leaves the residuals themselves, of L2.
  StepResult AddScores(const TrainingStep& step) override {
    const Batch batch{views_, step.blocks, step.jitter_px, step.seed};
    std::vector<Vec4<Real>> residuals(batch.rays());
    const StepResult result = CompareWithTargets(batch, March(batch), step, Real(0.5), residuals);
    AddShares(batch, residuals);
    return OneStepLate(result);
  }

  std::vector<float> ReadScores() override { return {scores_.begin(), scores_.end()}; }

  RenderedImage Render(const RenderView& view, int samples) override {
    const int width = view.camera.width, height = view.camera.height;
    const size_t pixels = size_t(width) * size_t(height);
    RenderedImage image{width, height, std::vector<glm::vec3>(pixels), std::vector<float>(pixels)};
    ParallelFor(pixels, kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        const glm::dvec2 corner(double(i % size_t(width)), double(i / size_t(width)));
        Vec3<Real> color(Real(0));
        Real transmittance(0);
        for (int sample = 0; sample < samples * samples; ++sample) {
          const glm::dvec2 inside =
              (glm::dvec2(sample % samples, sample / samples) + 0.5) / double(samples);
          const RayResult<Real> ray = Integrate(RayThrough<Real>(view, corner + inside));
          color += ray.color_srgb;
          transmittance += std::exp(-ray.optical_depth);
        }
        const Real share = Real(1) / Real(samples * samples);
        image.color_srgb[i] = glm::vec3(share * color);
        image.transmittance[i] = float(share * transmittance);
      }
    });
    counts_.rays += pixels * size_t(samples * samples);
    return image;
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const size_t width = size_t(view.camera.width), pixels = width * size_t(view.camera.height);
    TETREC_CHECK(pixel_gradient.size() == pixels, "one gradient a pixel");
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    ReferenceGradient sum(field_);
    AddGradients<Real>(
        field_, boxes_, pixels,
        [&](size_t i) {
          return RayThrough<Real>(view, {double(i % width) + 0.5, double(i / width) + 0.5});
        },
        [&](size_t i) { return Vec4<Real>(pixel_gradient[i]); }, stop_depth_, options_.integral,
        with_positions, sum);
    counts_.rays += pixels;
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
    const std::vector<Vec4<Real>> rays = March({std::span(&view, 1), blocks, 0.0f, 0});
    return {rays.begin(), rays.end()};
  }

  RenderCounts counts() const override {
    RenderCounts counts = counts_;
    counts.hit_rays = hit_rays_;
    counts.steps = steps_;
    return counts;
  }

  nlohmann::json DescribeDevice() const override {
    return {{"name", std::is_same_v<Real, double> ? "CPU, double precision" : "CPU, float"},
            {"type", "software"},
            {"threads", std::max(1u, std::thread::hardware_concurrency())}};
  }

  std::vector<std::string> ValidationMessages() const override { return {}; }

 private:
  // Rays of blocks of views.
  struct Batch {
    std::span<const RenderView> views;
    std::span<const RayBlock> blocks;
    float jitter_px;
    uint32_t seed;

    size_t rays() const { return blocks.size() * kRaysPerBlock; }
    const RenderView& ViewOf(size_t ray) const { return views[blocks[ray / kRaysPerBlock].view]; }
    bool InPicture(size_t ray) const {
      const glm::ivec2 at = PixelOfRay(blocks, ray);
      return at.x < ViewOf(ray).camera.width && at.y < ViewOf(ray).camera.height;
    }
  };

  // As rays.glsl.
  static WorldRay<Real> RayOf(const Batch& batch, size_t i) {
    const uint32_t random = gpu_types::Hash(batch.seed ^ gpu_types::Hash(uint32_t(i)));
    const glm::dvec2 unit(gpu_types::UnitFloat(random),
                          gpu_types::UnitFloat(gpu_types::Hash(random)));
    const glm::dvec2 in_pixel = 0.5 + double(batch.jitter_px) * (unit - 0.5);
    return RayThrough<Real>(batch.ViewOf(i), glm::dvec2(PixelOfRay(batch.blocks, i)) + in_pixel);
  }

  RayResult<Real> Integrate(const WorldRay<Real>& ray) {
    const auto result = IntegrateRay<Real>(field_, CutMesh<Real>(field_, boxes_, ray, stop_depth_),
                                           options_.integral);
    if (options_.count_steps && result.tets > 0) {
      ++hit_rays_;
      steps_ += result.tets;
    }
    return result;
  }

  // Colour before the background and optical depth of every ray; 0 outside the picture.
  std::vector<Vec4<Real>> March(const Batch& batch) {
    std::vector<Vec4<Real>> colors(batch.rays(), Vec4<Real>(Real(0)));
    ParallelFor(batch.rays(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        if (!batch.InPicture(i)) continue;
        const RayResult<Real> ray = Integrate(RayOf(batch, i));
        colors[i] = Vec4<Real>(ray.color_srgb, ray.optical_depth);
      }
    });
    counts_.rays += batch.rays();
    return colors;
  }

  // As loss.comp: means of the loss and of the squared error; dL/d(rgb, transmittance) of every
  // ray, 0 outside the picture.
  StepResult CompareWithTargets(const Batch& batch, std::span<const Vec4<Real>> colors,
                                const TrainingStep& step, Real gradient_scale,
                                std::span<Vec4<Real>> gradients) const {
    const int loss = step.loss == LossKind::kL2 ? kLossL2 : kLossL1;
    const Vec3<Real> background(step.background_srgb);
    StepResult result;
    for (size_t i = 0; i < batch.rays(); ++i) {
      gradients[i] = Vec4<Real>(Real(0));
      if (!batch.InPicture(i)) continue;
      const Vec4<Real> target = TargetOf(batch, i);
      const Real transmittance = std::exp(-colors[i].a);
      for (int c = 0; c < 3; ++c) {
        const Real residual =
            ResidualOf(colors[i][c], transmittance, target[c], target.a, background[c]);
        gradients[i][c] = gradient_scale * LossSlope(loss, residual);
        result.loss += double(LossOf(loss, residual));
        result.squared_error += double(residual) * double(residual);
      }
      gradients[i].a = glm::dot(Vec3<Real>(gradients[i]), background);
    }
    result.loss /= 3.0 * double(batch.rays());
    result.squared_error /= 3.0 * double(batch.rays());
    return result;
  }

  Vec4<Real> TargetOf(const Batch& batch, size_t ray) const {
    const TargetImage& target = targets_[batch.blocks[ray / kRaysPerBlock].view];
    const glm::ivec2 at = PixelOfRay(batch.blocks, ray);
    const uint32_t rgba8 = target.rgba8[size_t(at.y) * size_t(target.width) + size_t(at.x)];
    Vec4<Real> value;
    for (int c = 0; c < 4; ++c) value[c] = Real(rgba8 >> (8 * c) & 255u) / Real(255);
    return value;
  }

  // Gives D-SSIM its share of the loss and of the rays' gradients, tile by tile.
  void MixDssim(const Batch& batch, std::span<const Vec4<Real>> colors, const TrainingStep& step,
                std::span<Vec4<Real>> gradients, StepResult& result) const {
    const int width = int(step.tiles.columns) * kRayBlockWidth;
    const int height = int(step.tiles.rows) * kRayBlockHeight;
    const size_t pixels = size_t(width) * size_t(height);
    TETREC_CHECK(pixels > 0 && batch.rays() % pixels == 0, "D-SSIM wants tiles");
    const glm::dvec3 background(step.background_srgb);
    const double weight = step.dssim_weight;
    const double share = weight * double(pixels) / double(batch.rays());
    for (Vec4<Real>& gradient : gradients) gradient *= Real(1.0 - weight);
    result.loss *= 1.0 - weight;
    for (size_t first = 0; first < batch.rays(); first += pixels) {
      const glm::ivec2 corner = PixelOfRay(batch.blocks, first);
      const auto place = [&](size_t ray) {
        const glm::ivec2 at = PixelOfRay(batch.blocks, ray) - corner;
        return size_t(at.y) * size_t(width) + size_t(at.x);
      };
      std::vector<glm::dvec3> shown(pixels), wanted(pixels);
      for (size_t ray = first; ray < first + pixels; ++ray) {
        TETREC_CHECK(batch.InPicture(ray), "a tile of D-SSIM leaves its picture");
        const glm::dvec4 color(colors[ray]), target(TargetOf(batch, ray));
        shown[place(ray)] = glm::dvec3(color) + std::exp(-color.a) * background;
        wanted[place(ray)] = glm::dvec3(target) + (1.0 - target.a) * background;
        if (!IsJudged(target.r, target.a)) {
          shown[place(ray)] = wanted[place(ray)] = glm::dvec3(kNotJudged);
        }
      }
      const Dssim dssim = EvaluateDssim(shown, wanted, width, height);
      result.loss += share * dssim.value;
      for (size_t ray = first; ray < first + pixels; ++ray) {
        const glm::dvec3 g = share * dssim.gradient[place(ray)];
        gradients[ray] += Vec4<Real>(glm::dvec4(g, glm::dot(g, background)));
      }
    }
  }

  void TakeAdamStep(const TrainingStep& step, const ReferenceGradient& gradient) {
    const gpu_types::AdamPush push = MakeAdamPush(step, uint32_t(field_.density.size()));
    const AdamRates<Real> rates{Real(push.beta1), Real(push.beta2), Real(push.epsilon),
                                Real(push.second_moment_correction)};
    for (size_t v = 0; v < field_.density.size(); ++v) {
      const Vec4<Real> by_parameter(Vec3<Real>(gradient.color_srgb[v]),
                                    Real(gradient.density[v]) * Real(field_.density[v]));
      glm::vec4& row = state_.parameters[v];
      Vec4<Real> parameter(row);
      for (int c = 0; c < 4; ++c) {
        float& first = state_.first_moment[v][c];
        float& second = state_.second_moment[v][c];
        const AdamState<Real> next =
            AdamStep(AdamState<Real>{parameter[c], Real(first), Real(second)}, rates,
                     Real(c < 3 ? push.color_rate : push.density_rate), by_parameter[c]);
        parameter[c] = c < 3 ? ClampColor(next.parameter) : next.parameter;
        first = float(next.first);
        second = float(next.second);
      }
      if (by_parameter != Vec4<Real>(Real(0))) parameter.a -= Real(push.density_decay);
      parameter.a = ClampLogDensity(parameter.a, Real(push.max_log_density));
      row = glm::vec4(parameter);
      Spread(v);
    }
  }

  // Density and colour from the parameters.
  void Spread(size_t v) {
    field_.density[v] = float(std::exp(Real(state_.parameters[v].a)));
    field_.color_srgb[v] = glm::vec3(state_.parameters[v]);
  }

  // As march_score.comp, summed in the order of the rays.
  void AddShares(const Batch& batch, std::span<const Vec4<Real>> residuals) {
    struct Share {
      uint32_t tet;
      Real value;
    };
    std::vector<std::vector<Share>> lists((batch.rays() + kRaysPerTask - 1) / kRaysPerTask);
    ParallelFor(batch.rays(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        if (!batch.InPicture(i)) continue;
        const Vec3<Real> residual(residuals[i]);
        Real transmittance(1);
        for (const auto& segment : CutMesh<Real>(field_, boxes_, RayOf(batch, i), stop_depth_)) {
          const Real opacity = Real(1) - std::exp(-EndsOf(field_, segment).depth());
          const Real share = transmittance * opacity;
          if (share > Real(kLeastScoredShare)) {
            lists[first / kRaysPerTask].push_back(
                {segment.tet, glm::dot(residual, residual) * share});
          }
          transmittance *= Real(1) - opacity;
        }
      }
    });
    for (const std::vector<Share>& list : lists) {
      for (const Share& share : list) scores_[share.tet] += double(share.value);
    }
  }

  // As the others, whose batches are in flight two at a time.
  StepResult OneStepLate(const StepResult& result) {
    current_ ^= 1;
    return std::exchange(results_[current_], result);
  }

  RendererOptions options_;
  std::atomic<uint64_t> hit_rays_ = 0, steps_ = 0;  // by many threads
  Real stop_depth_;
  RadianceField field_;  // what the parameters of state_ mean
  TetBoxes boxes_;
  VertexState state_;
  std::vector<RenderView> views_;
  std::vector<TargetImage> targets_;
  std::vector<double> scores_;
  std::array<StepResult, 2> results_;
  int current_ = 0;
  RenderCounts counts_;
};

}  // namespace

std::unique_ptr<TrainingRenderer> CreateReferenceRenderer(const RendererOptions& options) {
  if (options.precision == Precision::kFloat) {
    return std::make_unique<ReferenceRenderer<float>>(options);
  }
  return std::make_unique<ReferenceRenderer<double>>(options);
}

}  // namespace tetrec
