// The end of a run without limits.
#include "optimize/convergence.h"

#include "optimize/schedule.h"

#include <algorithm>

namespace tetrec {
namespace {

// The first look follows the trials, which leave a field with little noise for a while.
constexpr double kFirstLook = kGrowthSteps, kLookFactor = 1.25;
constexpr double kLeastGain_db = 0.05;
constexpr uint64_t kMostIdleLooks = 2;
// The progress that a run tends to while it has not converged, and its fields are still judged.
constexpr double kOpenProgress = 0.65;
static_assert(kOpenProgress < ScheduleOptions().last_judging);

}  // namespace

bool Convergence::IsDue(uint64_t steps) const {
  if (state_.converged > 0) return false;
  return double(steps) >= std::max(kFirstLook, kLookFactor * double(state_.last_look));
}

void Convergence::Look(uint64_t steps, double psnr, bool may_end) {
  const bool gained = state_.last_look == 0 || psnr >= state_.best_psnr + kLeastGain_db;
  state_.idle_looks = gained || !may_end ? 0 : state_.idle_looks + 1;
  state_.best_psnr = gained ? psnr : state_.best_psnr;
  state_.last_look = steps;
  if (state_.idle_looks >= kMostIdleLooks) state_.converged = steps;
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
