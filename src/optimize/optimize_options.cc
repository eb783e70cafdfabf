// The options of the optimize stage: checks.
#include "optimize/optimize_options.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

// A tile of 16 x 16 pixels, with room for windows of 11 x 11.
constexpr int kLeastDssimRays = 256;
// D-SSIM has a thread for each channel of a ray, and every device can start at least 65,535
// workgroups of 64 threads.
constexpr int kMostRays = 1 << 20;

constexpr uint64_t kMostMegabytes = 1000000000;

}  // namespace

void OptimizeOptions::Check() const {
  const auto fail = [](const char* option, double value, const char* want) {
    throw UsageError(fmt::format("{} is {}, must be {}", option, value, want));
  };
  if (!(time_limit_s >= 0)) fail("time_limit", time_limit_s, "at least 0 s");
  if (!HasLimit() && judging_pictures == JudgingPictures::kLearned) {
    throw UsageError(
        "time_limit and 'iterations' are both 0 and 'judging_pictures' is learned, so nothing ends "
        "the run: set a limit, or 'judging_pictures' kept");
  }
  if (renderer.deterministic && time_limit_s > 0) {
    throw UsageError(
        "deterministic: a run by time ends where the machine's speed takes it; set 'time_limit' 0");
  }
  if (budget_tets > 0 && budget_mb > 0) {
    throw UsageError("budget_tets and 'budget_mb' bound the same mesh: give one of them");
  }
  if (budget_mb > kMostMegabytes) fail("budget_mb", double(budget_mb), "at most 1e9 MB");
  if (budget == BudgetChoice::kFull && budget_tets == 0 && budget_mb == 0 && max_vertices == 0) {
    throw UsageError(
        "budget is full, but nothing bounds the mesh: set 'budget_tets' or 'budget_mb'");
  }
  const OptimizeOptions defaults;
  if (refine != RefineScheme::kPrism) {
    if (split_share != defaults.split_share) {
      throw UsageError("split_share has no effect without refine prism; leave it out");
    }
    if (prism_diagonals != defaults.prism_diagonals) {
      throw UsageError("prism_diagonals has no effect without refine prism; leave it out");
    }
  }
  if (move == MoveChoice::kOff && (position_rate || quality.strength > 0)) {
    throw UsageError(
        "position_rate and 'quality_weight' have no effect with move off; leave them out");
  }
  if (!(split_share > 0)) fail("split_share", split_share, "above 0");
  if (rays_per_step && (*rays_per_step < kRaysPerBlock || *rays_per_step > kMostRays)) {
    fail("rays", *rays_per_step, "8 to 1048576");
  }
  if (loss.dssim > 0 && rays_per_step && *rays_per_step < kLeastDssimRays) {
    fail("rays", *rays_per_step, "at least 256 for a loss with D-SSIM, whose windows need tiles");
  }
  if (!(checkpoint_interval_s >= 0)) {
    fail("checkpoint_interval", checkpoint_interval_s, "at least 0 s");
  }
  if (density == DensityForm::kSigned && storage == FieldStorage::kCell) {
    throw UsageError(
        "density is signed, but storage is cell: density is constant in a cell, so there is no "
        "place at which it could change its sign; use storage vertex");
  }
  if (score == RefineScore::kGain && storage == FieldStorage::kCell) {
    throw UsageError(
        "score is gain, but storage is cell: what is predicted is the gain of a vertex with values "
        "of its own; use storage vertex, or score residual");
  }
  const bool march =
      renderer.kind == RendererKind::kMarch || renderer.kind == RendererKind::kReference;
  if (fine_rays == FineRaysChoice::kOn && (loss.dssim > 0 || !march)) {
    throw UsageError(
        "fine_rays is on, but losses with D-SSIM and the renderers ppll and projection train with "
        "one ray per pixel; use fine_rays off");
  }
  if (!(max_density > 0 && max_density <= 1e30))
    fail("max_density", max_density, "a number above 0, at most 1e30");
}

FirstRates FirstRatesOf(const OptimizeOptions& options, bool has_alpha) {
  constexpr double kShareForPhotos = 0.6;
  const double share = has_alpha ? 1.0 : kShareForPhotos;
  const AdamUpdate usual;
  return {.color = options.color_rate.value_or(share * usual.color_rate),
          .density = options.density_rate.value_or(share * usual.density_rate),
          .harmonics = options.harmonics_rate.value_or(share * usual.harmonics_rate)};
}

double PositionRateOf(const OptimizeOptions& options) {
  return options.position_rate.value_or(options.move == MoveChoice::kArticle ? 2e-5 : 0.1);
}

RefineScore ScoreOf(const OptimizeOptions& options) {
  if (options.score != RefineScore::kAuto) return options.score;
  return options.refine == RefineScheme::kPrism ? RefineScore::kColor : RefineScore::kResidual;
}

}  // namespace tetrec
