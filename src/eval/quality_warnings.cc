// What a reader of the report should know before trusting its numbers.
#include "eval/quality_warnings.h"

#include "core/quantile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// A view is far below the others by both: a difference that is seen, and that the scatter of the
// other views does not explain.
constexpr double kFarBelow_db = 3, kFarBelowDeviations = 2.5;
// Below this mean, renderings of most scenes are visibly blurred, foggy or misplaced.
constexpr double kLowPsnr_db = 22;
constexpr size_t kFewestViewsToCompare = 3;
// A rendering with less than this share of its photo's contrast shows hardly anything. Blur alone
// leaves more; a photo that shows hardly anything itself is not judged.
constexpr double kNearlyUniform = 0.25, kLeastContrast = 8;
constexpr size_t kFewTrainingViews = 15;

// Deviations are measured by the median absolute deviation, which the bad views do not inflate.
std::vector<std::string> ViewsFarBelow(const std::vector<ViewScore>& scores) {
  if (scores.size() < kFewestViewsToCompare) return {};
  std::vector<double> psnrs, deviations;
  for (const ViewScore& score : scores) psnrs.push_back(score.psnr);
  const double median = Quantile(psnrs, 0.5);
  if (!std::isfinite(median)) return {};
  for (const double psnr : psnrs) deviations.push_back(std::abs(psnr - median));
  const double limit =
      median - std::max(kFarBelow_db, kFarBelowDeviations * Quantile(deviations, 0.5));
  std::vector<std::string> far;
  for (const ViewScore& score : scores) {
    if (score.psnr < limit) far.push_back(fmt::format("{} ({:.1f} dB)", score.name, score.psnr));
  }
  if (far.empty()) return {};
  return {
      fmt::format("{} of {} views are far worse than the others, whose median is {:.1f} dB: {}. "
                  "Their cameras may be wrong, or no training view may show what they show.",
                  far.size(), scores.size(), median, fmt::join(far, ", "))};
}

std::vector<std::string> NearlyUniform(const std::vector<ViewScore>& scores) {
  std::vector<std::string> uniform;
  for (const ViewScore& score : scores) {
    if (score.truth_contrast >= kLeastContrast &&
        score.render_contrast < kNearlyUniform * score.truth_contrast) {
      uniform.push_back(score.name);
    }
  }
  if (uniform.empty()) return {};
  return {fmt::format(
      "{} of {} views are rendered in nearly one colour: {}. Density hides the scene from their "
      "cameras, because no training view stands near them, or their cameras are wrong.",
      uniform.size(), scores.size(), fmt::join(uniform, ", "))};
}

std::vector<std::string> LowQuality(const std::vector<ViewScore>& scores) {
  double sum = 0;
  // With the colours corrected, since photos of uneven exposure differ from good renderings, too.
  for (const ViewScore& score : scores) {
    sum += std::max(score.psnr, score.corrected_psnr.value_or(score.psnr));
  }
  const double mean = sum / double(scores.size());
  if (scores.empty() || !(mean < kLowPsnr_db)) return {};
  return {
      fmt::format("The views that were scored have a mean PSNR of only {:.1f} dB, even with "
                  "corrected colours: renderings are "
                  "blurred, foggy or misplaced. More time for optimisation, or more and sharper "
                  "photos, may help.",
                  mean)};
}

std::vector<std::string> FewTrainingViews(const Scene& scene) {
  const size_t views = scene.ViewsOf(Split::kTrain).size();
  if (views >= kFewTrainingViews) return {};
  return {
      fmt::format("There are only {} training views. Expect fog and wrong shapes where few of "
                  "them overlap; {} or more are better.",
                  views, kFewTrainingViews)};
}

}  // namespace

std::vector<std::string> QualityWarnings(const std::vector<ViewScore>& scores,
                                         const std::optional<Scene>& scene) {
  std::vector<std::string> warnings;
  const auto add = [&](std::vector<std::string> more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  add(LowQuality(scores));
  add(ViewsFarBelow(scores));
  add(NearlyUniform(scores));
  if (scene) add(FewTrainingViews(*scene));
  return warnings;
}

}  // namespace tetrec
