// The exposures of the training photos, estimated together with the field.
#include "optimize/exposure.h"

#include "core/quantile.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// Before this growth of the run (schedule.h) the picture is a blur, whose colours reveal little
// about single photos.
constexpr double kFirstGrowth = 0.03;
constexpr uint64_t kFitInterval = 16;  // steps
// The share of the older sums that each fit keeps: about the last 100 steps count.
constexpr double kKeptSums = 0.85;
// The share of the way to the fitted exposures that each fit goes.
constexpr double kDamping = 0.25;
// Bounds of a fitted gain.
constexpr double kSmallestGain = 0.2, kLargestGain = 5;
// The pull towards neutral: a share of the view's rays, and as many rays as make a view count.
constexpr double kGainShare = 1e-3, kOffsetShare = 1e-2, kPriorRays = 100;
// The spread (root mean square over views and channels of log gain) that is left in collections of
// even exposure by reflections, vignettes and what the field has not learned.
constexpr double kEvenSpread = 0.01;

GainOffset FitChannel(const GainOffsetSums& sums) {
  const GainOffsetPrior prior{kGainShare * sums.ww + kPriorRays,
                              kOffsetShare * sums.ww + kPriorRays};
  GainOffset fit = FitGainOffset(sums, prior).value_or(GainOffset{});
  fit.gain = std::clamp(fit.gain, kSmallestGain, kLargestGain);
  return fit;
}

void Scale(std::span<ExposureSums> sums, double factor) {
  for (ExposureSums& view : sums) {
    for (GainOffsetSums& s : view) {
      s = {factor * s.ww, factor * s.xw, factor * s.xx, factor * s.yw, factor * s.yx};
    }
  }
}

}  // namespace

std::vector<ViewExposure> FitExposures(std::span<const ExposureSums> sums) {
  std::vector<ViewExposure> exposures(sums.size());
  for (size_t view = 0; view < sums.size(); ++view) {
    for (int c = 0; c < 3; ++c) {
      const GainOffset fit = FitChannel(sums[view][size_t(c)]);
      exposures[view].gain[c] = fit.gain;
      exposures[view].offset[c] = fit.offset;
    }
  }
  return exposures;
}

void MakeMedianNeutral(std::span<ViewExposure> exposures) {
  if (exposures.empty()) return;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> log_gains, offsets;
    for (const ViewExposure& exposure : exposures) {
      log_gains.push_back(std::log(exposure.gain[c]));
      offsets.push_back(exposure.offset[c]);
    }
    const double gain = std::exp(-Median(log_gains));
    const double offset = Median(offsets);
    for (ViewExposure& exposure : exposures) {
      exposure.gain[c] *= gain;
      exposure.offset[c] -= offset;
    }
  }
}

void ShrinkToEvidence(std::span<ViewExposure> exposures) {
  double squares = 0;
  for (const ViewExposure& exposure : exposures) {
    const glm::dvec3 log_gain = glm::log(exposure.gain);
    squares += glm::dot(log_gain, log_gain) + glm::dot(exposure.offset, exposure.offset);
  }
  const double expected = 3 * double(exposures.size()) * kEvenSpread * kEvenSpread;
  const double kept = squares > expected ? 1 - expected / squares : 0;
  for (ViewExposure& exposure : exposures) {
    exposure.gain = glm::exp(kept * glm::log(exposure.gain));
    exposure.offset *= kept;
  }
}

ExposureEstimate::ExposureEstimate(size_t views) : state_{{}, {}} {
  // A single view is its own mean.
  if (views < 2) return;
  state_.exposures.resize(views);
  state_.sums.resize(views);
}

bool ExposureEstimate::Gathers(double growth) const { return is_on() && growth >= kFirstGrowth; }

bool ExposureEstimate::IsFitDue(uint64_t iteration, double growth) const {
  return Gathers(growth) && iteration % kFitInterval == 0;
}

void ExposureEstimate::Fit(TrainingRenderer& renderer) {
  renderer.AddExposureSums(state_.sums);
  std::vector<ViewExposure> fitted = FitExposures(state_.sums);
  MakeMedianNeutral(fitted);
  ShrinkToEvidence(fitted);
  for (size_t view = 0; view < fitted.size(); ++view) {
    ViewExposure& exposure = state_.exposures[view];
    exposure.gain =
        glm::exp(glm::mix(glm::log(exposure.gain), glm::log(fitted[view].gain), kDamping));
    exposure.offset = glm::mix(exposure.offset, fitted[view].offset, kDamping);
  }
  MakeMedianNeutral(state_.exposures);
  Scale(state_.sums, kKeptSums);
  renderer.SetExposures(state_.exposures);
}

const ExposureState& ExposureEstimate::State(TrainingRenderer& renderer) {
  if (is_on()) renderer.AddExposureSums(state_.sums);
  return state_;
}

}  // namespace tetrec
