// The end of a run without limits.
#include "optimize/convergence.h"

#include "optimize/schedule.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

constexpr double kGrowthSteps = kGrowthSeconds * kStepsPerSecond;
// The first look, long before which a field is still far from its end.
constexpr uint64_t kFirstLook = uint64_t(kGrowthSteps / 2);
constexpr double kLookFactor = 1.25;
constexpr double kLeastGain = 0.05;  // from one look to the next [dB]
// The progress that a run tends to while it has not converged: the trials that belong to the end of
// a run follow it.
constexpr double kOpenProgress = 0.65;
static_assert(kOpenProgress < ScheduleOptions().last_judging);

}  // namespace

bool Convergence::IsDue(uint64_t steps) const {
  if (state_.converged > 0) return false;
  return double(steps) >= std::max(double(kFirstLook), kLookFactor * double(state_.last_look));
}

std::optional<double> Convergence::Look(uint64_t steps, std::vector<ErrorSum> views, bool may_end) {
  std::optional<double> gain;
  if (!state_.last_views.empty()) gain = GainBetween(state_.last_views, views).gain;
  if (may_end && gain && *gain < kLeastGain) state_.converged = steps;
  state_.last_look = steps;
  state_.last_views = std::move(views);
  return gain;
}

double Convergence::Progress(uint64_t steps) const {
  if (state_.converged == 0) {
    const double growth = double(steps) / kGrowthSteps;
    return kOpenProgress * growth / (1.0 + growth);
  }
  const double all = double(state_.converged) / ScheduleOptions().last_judging;
  return std::min(double(steps) / all, 1.0);
}

}  // namespace tetrec
