// The reference renderer behind the interface of the others: images, gradients and training steps
// on the CPU.
#include "render/reference/reference_renderer.h"

#include "core/error.h"
#include "render/field_checks.h"
#include "render/ray_blocks.h"
#include "render/reference/batch.h"
#include "render/reference/dssim.h"
#include "render/reference/row_update.h"
#include "render/seen_colors.h"
#include "shared/exposure.glsl.h"
#include "shared/loss.glsl.h"
#include "shared/random.glsl.h"
#include "shared/ssim.glsl.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <thread>

namespace tetrec {
namespace {

// The memory of a field: per tet the mesh, its boxes and scores; per component of a row the
// parameter, moments and sum of gradients; per row what it has besides.
constexpr uint64_t kBytesPerTet = 100, kBytesPerComponent = 40, kBytesPerRow = 40;

template <class Real>
class ReferenceRenderer final : public ProbedRenderer {
 public:
  explicit ReferenceRenderer(const RendererOptions& options)
      : options_(options), stop_depth_(StopDepthOf<Real>(options.stop_transmittance)) {}

  // Keeps the field's own densities instead of converting them to logarithms and back.
  void SetField(const RadianceField& field) override {
    CheckField(field);
    SetState(field.mesh, StateOf(field));
    field_ = field;
  }

  void SetState(TetMesh mesh, const FieldState& state) override {
    CheckRenderable(mesh, state);
    const size_t rows = state.rows(), components = size_t(state.layout.Components());
    CheckMemory(
        mesh,
        kBytesPerTet * mesh.tets.size() + (kBytesPerRow + kBytesPerComponent * components) * rows,
        MeasureFreeHostMemory());
    state_ = state;
    field_ = MakeField(std::move(mesh), state.layout, std::vector<float>(rows * components));
    for (size_t row = 0; row < rows; ++row) Spread(row);
    rate_shares_.assign(rows, 1.0f);
    boxes_ = MakeTetBoxes(field_.mesh);
    scores_.assign(field_.mesh.tets.size(), 0.0);
    ClearSums();
    forward_.reset();
  }

  FieldState ReadState() override { return state_; }

  const TetMesh& mesh() const override { return field_.mesh; }

  TetMesh TakeMesh() override {
    TetMesh mesh = std::move(field_.mesh);
    field_ = {};
    boxes_ = {};
    forward_.reset();
    has_position_sums_ = false;
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
    views_.assign(views.begin(), views.end());
    targets_.assign(targets.begin(), targets.end());
    if (exposures_.size() == views.size()) return;
    exposures_.assign(views.size(), {});
    block_sums_.clear();
  }

  void SetExposures(std::span<const ViewExposure> exposures) override {
    TETREC_CHECK(exposures.size() == views_.size(), "one exposure per view");
    exposures_.assign(exposures.begin(), exposures.end());
  }

  void AddExposureSums(std::span<ExposureSums> sums) override {
    AddBlockSums(block_sums_, sums);
    block_sums_.clear();
  }

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
    forward_->jitter_px = batch.jitter_px;
    forward_->seed = batch.seed;
    forward_->samples = batch.samples;
    const Batch rays = ForwardBatch();
    std::vector<Vec4<Real>>& gradients = forward_->gradients;
    gradients.resize(rays.rays());
    const std::vector<Vec4<Real>> shown = ShownPixels(rays, March(rays));
    const Real scale = Real(1) / Real(3 * batch.rays_of_mean());
    StepResult result = CompareWithTargets(rays, shown, batch, scale, gradients);
    ChainToRays(rays, batch, gradients);
    if (batch.sums_exposures) SumExposures(rays, shown, batch);
    if (batch.dssim_weight > 0) MixDssim(rays, shown, batch, gradients, result);
    return result;
  }

  void Backward(GradientParts parts) override {
    TETREC_CHECK(forward_, "Backward follows Forward");
    const Batch rays = ForwardBatch();
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    for (const auto& [view, seen] : SeenBy(rays)) {
      ReferenceGradient sum(field_);
      AddGradientsOfRays(
          *seen, rays.rays(), [&](size_t i) { return RayOf(rays, i); },
          [&](size_t i) {
            return seen.get() == &field_ || rays.IndexOfView(i) == view ? forward_->gradients[i]
                                                                        : Vec4<Real>(Real(0));
          },
          with_positions, sum);
      AddToSums(sum, CenterOf(views_[view]));
    }
    has_position_sums_ |= with_positions;
  }

  GradientSums TakeGradients() override {
    const size_t components = size_t(state_.layout.Components()), rows = state_.rows();
    GradientSums result;
    result.values.resize(rows * components);
    for (size_t row = 0; row < rows; ++row) {
      for (size_t c = 0; c < components; ++c) result.values[row * components + c] = SumAt(row, c);
    }
    if (has_position_sums_) {
      result.position = sums_.position;
      result.absolute_position = sums_.absolute_position;
    }
    ClearSums();
    return result;
  }

  GradientSums TakePositionGradients() override {
    GradientSums result;
    if (!std::exchange(has_position_sums_, false)) return result;
    const size_t vertices = sums_.position.size();
    result.position = std::exchange(sums_.position, std::vector<glm::dvec3>(vertices));
    result.absolute_position =
        std::exchange(sums_.absolute_position, std::vector<double>(vertices));
    return result;
  }

  void MoveVertices(std::span<const glm::vec3> positions) override {
    field_.mesh.positions.assign(positions.begin(), positions.end());
    boxes_ = MakeTetBoxes(field_.mesh);
    forward_.reset();
  }

  void AddGradients(const GradientSums& sums) override {
    const size_t components = size_t(state_.layout.Components()), rows = state_.rows();
    const size_t vertices = field_.mesh.positions.size();
    TETREC_CHECK(sums.values.size() == rows * components, "one gradient per component");
    TETREC_CHECK(sums.position.size() == sums.absolute_position.size() &&
                     (sums.position.empty() || sums.position.size() == vertices),
                 "one gradient per position, or none");
    for (size_t row = 0; row < rows; ++row) {
      for (size_t c = 0; c < components; ++c) SumAt(row, c) += sums.values[row * components + c];
    }
    for (size_t v = 0; v < sums.position.size(); ++v) {
      sums_.position[v] += sums.position[v];
      sums_.absolute_position[v] += sums.absolute_position[v];
    }
    has_position_sums_ |= !sums.position.empty();
  }

  void Update(const AdamUpdate& update) override {
    const RowUpdate<Real> row_update(update, state_.layout);
    const std::vector<const Attribute*> attributes = state_.layout.ByComponent();
    std::vector<Real> by_parameter(attributes.size());
    for (size_t row = 0; row < state_.rows(); ++row) {
      for (size_t c = 0; c < attributes.size(); ++c) {
        by_parameter[c] =
            Real(SumAt(row, c)) * ActivationSlope(*attributes[c], Real(ValueAt(row, c)));
      }
      row_update.Apply(state_, row, by_parameter, Real(rate_shares_[row]));
      Spread(row);
    }
    ClearValueSums();
  }

  void SetRateShares(std::span<const float> shares) override {
    CheckRateShares(shares, state_.rows());
    rate_shares_.assign(shares.begin(), shares.end());
  }

  void WriteParameters(std::span<const float> parameters) override {
    CheckRows(parameters, state_.layout, state_.rows(), "parameters");
    state_.parameters.assign(parameters.begin(), parameters.end());
    for (size_t row = 0; row < state_.rows(); ++row) Spread(row);
  }

  void ClearScores() override { scores_.assign(scores_.size(), 0.0); }

  // A gradient scale of 1/2 makes the gradients of L2 the residuals themselves.
  StepResult AddScores(const TrainingBatch& batch, ScoreKind kind) override {
    TETREC_CHECK(batch.samples == 1, "scores take one ray per pixel");
    const Batch rays{views_, batch.blocks, batch.jitter_px, batch.seed, batch.samples};
    TrainingBatch by_square = batch;
    by_square.loss = LossKind::kL2;
    std::vector<Vec4<Real>> residuals(rays.rays());
    const StepResult result =
        CompareWithTargets(rays, ShownPixels(rays, March(rays)), by_square, Real(0.5), residuals);
    AddShares(rays, residuals, kind);
    return OneStepLate(result);
  }

  std::vector<float> ReadScores() override { return {scores_.begin(), scores_.end()}; }

  RenderedImage Render(const RenderView& view, int samples) override {
    const int width = view.camera.width, height = view.camera.height;
    const size_t pixels = size_t(width) * size_t(height);
    const RadianceField seen = FieldSeenFrom(field_, CenterOf(view));
    RenderedImage image{width, height, std::vector<glm::vec3>(pixels), std::vector<float>(pixels)};
    ParallelFor(pixels, kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        const glm::dvec2 corner(double(i % size_t(width)), double(i / size_t(width)));
        Vec3<Real> color(Real(0));
        Real transmittance(0);
        for (int sample = 0; sample < samples * samples; ++sample) {
          const glm::dvec2 inside =
              (glm::dvec2(sample % samples, sample / samples) + 0.5) / double(samples);
          const RayResult<Real> ray = Integrate(seen, RayThrough<Real>(view, corner + inside));
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

  DepthMap RenderDepth(const RenderView& view) override {
    const int width = view.camera.width, height = view.camera.height;
    DepthMap map = MakeDepthMap(width, height);
    ParallelFor(map.depth.size(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        const glm::ivec2 at(int(i % size_t(width)), int(i / size_t(width)));
        const WorldRay<Real> ray = RayThrough<Real>(view, glm::dvec2(at) + 0.5);
        const auto segments = CutMesh<Real>(field_, boxes_, ray, Real(kHalfLightDepth));
        const std::optional<Real> reach = ReachOf<Real>(field_, segments, Real(kHalfLightDepth));
        if (reach) map.depth[i] = float(DepthOfDistance(view.camera, at, double(*reach)));
      }
    });
    counts_.rays += map.depth.size();
    return map;
  }

  FieldGradient Backpropagate(const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                              GradientParts parts) override {
    const size_t width = size_t(view.camera.width), pixels = width * size_t(view.camera.height);
    TETREC_CHECK(pixel_gradient.size() == pixels, "one gradient per pixel");
    const bool with_positions = parts == GradientParts::kColorDensityPosition;
    ReferenceGradient sum(field_);
    AddGradientsOfRays(
        FieldSeenFrom(field_, CenterOf(view)), pixels,
        [&](size_t i) {
          return RayThrough<Real>(view, {double(i % width) + 0.5, double(i / width) + 0.5});
        },
        [&](size_t i) { return Vec4<Real>(pixel_gradient[i]); }, with_positions, sum);
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
    const std::vector<Vec4<Real>> rays = March({std::span(&view, 1), blocks, 0.0f, 0, 1});
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
  // The rays of blocks of views.
  struct Batch {
    std::span<const RenderView> views;
    std::span<const RayBlock> blocks;
    float jitter_px;
    uint32_t seed;
    int samples;  // per pixel along each side

    size_t rays() const { return blocks.size() * kRaysPerBlock; }
    uint32_t IndexOfView(size_t ray) const { return blocks[ray / kRaysPerBlock].view; }
    const RenderView& ViewOf(size_t ray) const { return views[IndexOfView(ray)]; }
    bool InPicture(size_t ray) const {
      const glm::ivec2 at = PixelAt(ray);
      return at.x < ViewOf(ray).camera.width && at.y < ViewOf(ray).camera.height;
    }
    bool IsFirstOfPixel(size_t ray) const {
      const glm::ivec2 at = PixelOfRay(blocks, ray);
      return at.x % samples == 0 && at.y % samples == 0;
    }
    glm::ivec2 PixelAt(size_t ray) const { return PixelOfRay(blocks, ray) / samples; }
  };

  // What Backward needs of the batch of Forward.
  struct ForwardedBatch {
    std::vector<RayBlock> blocks;
    float jitter_px = 0;
    uint32_t seed = 0;
    int samples = 1;
    std::vector<Vec4<Real>> gradients;  // dL/d(rgb, transmittance) of each ray
  };

  Batch ForwardBatch() const {
    return {views_, forward_->blocks, forward_->jitter_px, forward_->seed, forward_->samples};
  }

  template <class RayOf, class GradientOf>
  void AddGradientsOfRays(const RadianceField& seen, size_t count, const RayOf& ray,
                          const GradientOf& gradient, bool with_positions,
                          ReferenceGradient& sum) const {
    tetrec::AddGradients<Real>(seen, boxes_, count, ray, gradient, stop_depth_, options_.integral,
                               with_positions, sum);
  }

  static glm::dvec3 CenterOf(const RenderView& view) {
    return view.cam_from_world.Inverse().translation;
  }

  // The field as each view of a batch sees it. If colours do not depend on the view, one entry that
  // is the field itself, for all views.
  using SeenFields = std::map<uint32_t, std::shared_ptr<const RadianceField>>;
  SeenFields SeenBy(const Batch& batch) const {
    const auto itself = std::shared_ptr<const RadianceField>(std::shared_ptr<void>(), &field_);
    SeenFields seen;
    if (state_.layout.HarmonicsDegree() == 0) {
      seen[batch.blocks[0].view] = itself;
      return seen;
    }
    for (const RayBlock& block : batch.blocks) {
      if (seen.contains(block.view)) continue;
      seen[block.view] = std::make_shared<const RadianceField>(
          FieldSeenFrom(field_, CenterOf(batch.views[block.view])));
    }
    return seen;
  }

  static const RadianceField& FieldFor(const SeenFields& seen, const Batch& batch, size_t ray) {
    return *(seen.size() == 1 ? seen.begin()->second : seen.at(batch.IndexOfView(ray)));
  }

  // Adds gradients by the colours that a camera at `center` sees, and all others.
  void AddToSums(const ReferenceGradient& sum, const glm::dvec3& center) {
    const size_t others = size_t(state_.layout.Components()) - kStandardComponents;
    const size_t count = size_t(HarmonicsCount(state_.layout.HarmonicsDegree()));
    const std::vector<glm::vec3> places = PlacesOfRows(field_.mesh, field_.storage);
    for (size_t row = 0; row < places.size(); ++row) {
      sums_.color_srgb[row] += sum.color_srgb[row];
      sums_.density[row] += sum.density[row];
      const auto basis = HarmonicsAt(DirectionTo(glm::dvec3(places[row]), center));
      for (size_t i = 0; i < 3 * count; ++i) {
        other_sums_[row * others + i] += basis[i / 3] * sum.color_srgb[row][int(i % 3)];
      }
    }
    for (size_t v = 0; v < sum.position.size(); ++v) {
      sums_.position[v] += sum.position[v];
      sums_.absolute_position[v] += sum.absolute_position[v];
    }
  }

  void ClearSums() {
    sums_ = ReferenceGradient(field_);
    const size_t others = size_t(state_.layout.Components()) - kStandardComponents;
    other_sums_.assign(state_.rows() * others, 0.0);
    has_position_sums_ = false;
  }

  void ClearValueSums() {
    std::fill(sums_.color_srgb.begin(), sums_.color_srgb.end(), glm::dvec3(0.0));
    std::fill(sums_.density.begin(), sums_.density.end(), 0.0);
    std::fill(other_sums_.begin(), other_sums_.end(), 0.0);
  }

  float ValueAt(size_t row, size_t component) const {
    if (component < kDensityOffset) return field_.color_srgb[row][int(component)];
    if (component == kDensityOffset) return field_.density[row];
    component -= kStandardComponents;
    for (const AttributeValues& other : field_.others) {
      const size_t count = size_t(other.attribute.components);
      if (component < count) return other.values[row * count + component];
      component -= count;
    }
    TETREC_CHECK(false, "no such component");
    return 0;
  }

  // The sum of dL/dvalue of a component of a row.
  double& SumAt(size_t row, size_t component) {
    if (component < kDensityOffset) return sums_.color_srgb[row][int(component)];
    if (component == kDensityOffset) return sums_.density[row];
    const size_t others = size_t(state_.layout.Components()) - kStandardComponents;
    return other_sums_[row * others + component - kStandardComponents];
  }

  // The same ray as in rays.glsl.
  static WorldRay<Real> RayOf(const Batch& batch, size_t i) {
    const uint32_t random = gpu_types::Hash(batch.seed ^ gpu_types::Hash(uint32_t(i)));
    const glm::dvec2 unit(gpu_types::UnitFloat(random),
                          gpu_types::UnitFloat(gpu_types::Hash(random)));
    const glm::dvec2 inside = 0.5 + double(batch.jitter_px) * (unit - 0.5);
    const glm::dvec2 in_grid = glm::dvec2(PixelOfRay(batch.blocks, i)) + inside;
    return RayThrough<Real>(batch.ViewOf(i), in_grid / double(batch.samples));
  }

  RayResult<Real> Integrate(const RadianceField& seen, const WorldRay<Real>& ray) {
    const auto result =
        IntegrateRay<Real>(seen, CutMesh<Real>(seen, boxes_, ray, stop_depth_), options_.integral);
    if (options_.count_steps && result.tets > 0) {
      ++hit_rays_;
      steps_ += result.tets;
    }
    return result;
  }

  // Colour before the background and optical depth of every ray; 0 outside the image.
  std::vector<Vec4<Real>> March(const Batch& batch) {
    std::vector<Vec4<Real>> colors(batch.rays(), Vec4<Real>(Real(0)));
    const SeenFields seen = SeenBy(batch);
    ParallelFor(batch.rays(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        if (!batch.InPicture(i)) continue;
        const RayResult<Real> ray = Integrate(FieldFor(seen, batch, i), RayOf(batch, i));
        colors[i] = Vec4<Real>(ray.color_srgb, ray.optical_depth);
      }
    });
    counts_.rays += batch.rays();
    return colors;
  }

  // As shown_pixels.glsl, for every ray: colour before the background and transmittance of its
  // pixel, the means over the pixel's rays.
  static std::vector<Vec4<Real>> ShownPixels(const Batch& batch, std::vector<Vec4<Real>> colors) {
    for (Vec4<Real>& color : colors) color.a = std::exp(-color.a);
    if (batch.samples == 1) return colors;
    TETREC_CHECK(batch.samples == 2, "1 or 2 x 2 rays per pixel");
    std::vector<Vec4<Real>> shown;
    for (size_t ray = 0; ray < colors.size(); ++ray) {
      Vec4<Real> sum(Real(0));
      for (const size_t other : {ray, ray ^ 1, ray ^ kRayBlockWidth, ray ^ (kRayBlockWidth + 1)}) {
        sum += colors[other];
      }
      shown.push_back(Real(0.25) * sum);
    }
    return shown;
  }

  // As loss.comp: the means of the loss and of the squared error, and dL/dshown of every ray, 0
  // outside the image. `shown`: ShownPixels.
  StepResult CompareWithTargets(const Batch& batch, std::span<const Vec4<Real>> shown,
                                const TrainingBatch& training, Real gradient_scale,
                                std::span<Vec4<Real>> gradients) const {
    const int loss = int(training.loss);
    const Vec3<Real> background(training.background_srgb);
    StepResult result;
    for (size_t i = 0; i < batch.rays(); ++i) {
      gradients[i] = Vec4<Real>(Real(0));
      if (!batch.InPicture(i)) continue;
      const Vec4<Real> target = TargetOf(batch, i);
      for (int c = 0; c < 3; ++c) {
        const Real residual = ResidualOf(Exposed(batch, i, shown[i])[c], shown[i].a, target[c],
                                         target.a, background[c]);
        gradients[i][c] = gradient_scale * LossSlope(loss, residual);
        result.loss += double(LossOf(loss, residual));
        result.squared_error += double(residual) * double(residual);
      }
    }
    result.loss /= 3.0 * double(batch.rays());
    result.squared_error /= 3.0 * double(batch.rays());
    return result;
  }

  const ViewExposure& ExposureOf(const Batch& batch, size_t ray) const {
    return exposures_[batch.blocks[ray / kRaysPerBlock].view];
  }

  // The colour of a ray's pixel as its view exposes it.
  Vec3<Real> Exposed(const Batch& batch, size_t ray, const Vec4<Real>& shown) const {
    const ViewExposure& exposure = ExposureOf(batch, ray);
    Vec3<Real> exposed;
    for (int c = 0; c < 3; ++c) {
      exposed[c] =
          ExposedColor(shown[c], shown.a, Real(exposure.gain[c]), Real(exposure.offset[c]));
    }
    return exposed;
  }

  // dL/d(color, transmittance) of a ray for dL/dshown.
  Vec4<Real> GradientOfRay(const Batch& batch, size_t ray, const Vec3<Real>& by_shown,
                           const Vec3<Real>& background) const {
    const ViewExposure& exposure = ExposureOf(batch, ray);
    return {by_shown * Vec3<Real>(exposure.gain),
            glm::dot(by_shown, background - Vec3<Real>(exposure.offset))};
  }

  void ChainToRays(const Batch& batch, const TrainingBatch& training,
                   std::span<Vec4<Real>> gradients) const {
    const Vec3<Real> background(training.background_srgb);
    for (size_t i = 0; i < gradients.size(); ++i) {
      gradients[i] = GradientOfRay(batch, i, Vec3<Real>(gradients[i]), background);
    }
  }

  // As exposure_sums.comp.
  void SumExposures(const Batch& batch, std::span<const Vec4<Real>> shown,
                    const TrainingBatch& training) {
    for (size_t i = 0; i < batch.rays(); ++i) {
      if (i % kRaysPerBlock == 0) block_sums_.push_back({batch.blocks[i / kRaysPerBlock].view, {}});
      if (!batch.InPicture(i) || !batch.IsFirstOfPixel(i)) continue;
      const Vec4<Real> target = TargetOf(batch, i);
      if (!IsJudged(target.r, target.a)) continue;
      for (int c = 0; c < 3; ++c) {
        const Real wanted =
            WantedColor(shown[i].a, target[c], target.a, Real(training.background_srgb[c]));
        block_sums_.back().sums[size_t(c)].Add(double(shown[i][c]), 1.0 - double(shown[i].a),
                                               double(wanted));
      }
    }
  }

  Vec4<Real> TargetOf(const Batch& batch, size_t ray) const {
    const TargetImage& target = targets_[batch.blocks[ray / kRaysPerBlock].view];
    const glm::ivec2 at = batch.PixelAt(ray);
    const uint32_t rgba8 = target.rgba8[size_t(at.y) * size_t(target.width) + size_t(at.x)];
    Vec4<Real> value;
    for (int c = 0; c < 4; ++c) value[c] = Real(rgba8 >> (8 * c) & 255u) / Real(255);
    return value;
  }

  // Gives D-SSIM its share of the loss and of the rays' gradients, tile by tile.
  void MixDssim(const Batch& batch, std::span<const Vec4<Real>> shown,
                const TrainingBatch& training, std::span<Vec4<Real>> gradients,
                StepResult& result) const {
    const int width = int(training.tiles.columns) * kRayBlockWidth;
    const int height = int(training.tiles.rows) * kRayBlockHeight;
    const size_t pixels = size_t(width) * size_t(height);
    TETREC_CHECK(batch.samples == 1, "D-SSIM takes one ray per pixel");
    TETREC_CHECK(pixels > 0 && batch.rays() % pixels == 0, "D-SSIM needs tiles");
    const glm::dvec3 background(training.background_srgb);
    const double weight = training.dssim_weight;
    const double share = weight * double(pixels) / double(batch.rays());
    const double share_of_mean = weight * double(pixels) / double(training.rays_of_mean());
    for (Vec4<Real>& gradient : gradients) gradient *= Real(1.0 - weight);
    result.loss *= 1.0 - weight;
    for (size_t first = 0; first < batch.rays(); first += pixels) {
      const glm::ivec2 corner = PixelOfRay(batch.blocks, first);
      const auto place = [&](size_t ray) {
        const glm::ivec2 at = PixelOfRay(batch.blocks, ray) - corner;
        return size_t(at.y) * size_t(width) + size_t(at.x);
      };
      std::vector<glm::dvec3> rendered(pixels), wanted(pixels);
      for (size_t ray = first; ray < first + pixels; ++ray) {
        TETREC_CHECK(batch.InPicture(ray), "a tile of D-SSIM leaves its picture");
        const glm::dvec4 target(TargetOf(batch, ray));
        rendered[place(ray)] =
            glm::dvec3(Exposed(batch, ray, shown[ray])) + double(shown[ray].a) * background;
        wanted[place(ray)] = glm::dvec3(target) + (1.0 - target.a) * background;
        if (!IsJudged(target.r, target.a)) {
          rendered[place(ray)] = wanted[place(ray)] = glm::dvec3(kNotJudged);
        }
      }
      const Dssim dssim = EvaluateDssim(rendered, wanted, width, height);
      result.loss += share * dssim.value;
      for (size_t ray = first; ray < first + pixels; ++ray) {
        const glm::dvec3 g = share_of_mean * dssim.gradient[place(ray)];
        gradients[ray] += GradientOfRay(batch, ray, Vec3<Real>(g), Vec3<Real>(background));
      }
    }
  }

  // Density and colour from the parameters, and the other attributes.
  void Spread(size_t row) {
    const size_t components = size_t(state_.layout.Components());
    const float* parameters = &state_.parameters[row * components];
    field_.density[row] = float(ValueOf(state_.layout.density(), Real(parameters[kDensityOffset])));
    for (int c = 0; c < 3; ++c) field_.color_srgb[row][c] = parameters[kColorOffset + c];
    const float* parameter = parameters + kStandardComponents;
    for (AttributeValues& other : field_.others) {
      const size_t count = size_t(other.attribute.components);
      for (size_t c = 0; c < count; ++c) {
        other.values[row * count + c] = ValueOf(other.attribute, *parameter++);
      }
    }
  }

  // As march_score.comp, but summed in the order of the rays.
  void AddShares(const Batch& batch, std::span<const Vec4<Real>> residuals, ScoreKind kind) {
    struct Share {
      uint32_t tet;
      Real value;
    };
    const double least_share = kind == ScoreKind::kVisible ? kLeastVisibleShare : kLeastScoredShare;
    std::vector<std::vector<Share>> lists((batch.rays() + kRaysPerTask - 1) / kRaysPerTask);
    ParallelFor(batch.rays(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        if (!batch.InPicture(i)) continue;
        const Vec3<Real> residual(residuals[i]);
        const Real error = kind == ScoreKind::kVisible ? Real(1)
                           : kind == ScoreKind::kSquaredResidual
                               ? glm::dot(residual, residual)
                               : glm::dot(glm::abs(residual), Vec3<Real>(Real(1)));
        Real transmittance(1);
        for (const auto& segment : CutMesh<Real>(field_, boxes_, RayOf(batch, i), stop_depth_)) {
          const Real opacity = Real(1) - std::exp(-EndsOf(field_, segment).depth());
          const Real share = transmittance * opacity;
          if (double(share) > least_share) {
            lists[first / kRaysPerTask].push_back({segment.tet, error * share});
          }
          transmittance *= Real(1) - opacity;
        }
      }
    });
    for (const std::vector<Share>& list : lists) {
      for (const Share& share : list) scores_[share.tet] += double(share.value);
    }
  }

  // Like the other renderers, which have two batches in flight.
  StepResult OneStepLate(const StepResult& result) {
    current_ ^= 1;
    return std::exchange(results_[current_], result);
  }

  RendererOptions options_;
  std::atomic<uint64_t> hit_rays_ = 0, steps_ = 0;  // counted by many threads
  Real stop_depth_;
  RadianceField field_;  // the values of the parameters in state_
  TetBoxes boxes_;
  FieldState state_;
  std::vector<float> rate_shares_;  // of the rows
  ReferenceGradient sums_{0, 0};    // since the last update
  std::vector<double> other_sums_;  // of attributes beside colour and density, row by row
  bool has_position_sums_ = false;
  std::optional<ForwardedBatch> forward_;
  std::vector<RenderView> views_;
  std::vector<TargetImage> targets_;
  std::vector<ViewExposure> exposures_;        // one per view
  std::vector<BlockExposureSums> block_sums_;  // since AddExposureSums
  std::vector<double> scores_;
  std::array<StepResult, 2> results_;
  int current_ = 0;
  RenderCounts counts_;
};

}  // namespace

std::unique_ptr<ProbedRenderer> CreateReferenceRenderer(const RendererOptions& options) {
  if (options.precision == Precision::kFloat) {
    return std::make_unique<ReferenceRenderer<float>>(options);
  }
  return std::make_unique<ReferenceRenderer<double>>(options);
}

}  // namespace tetrec
