// Finds learning rates that do not spoil the start.
#include "optimize/rate_trial.h"

#include "core/log.h"

namespace tetrec {
namespace {

constexpr uint64_t kTrialSteps = 20;
// A run of few steps has none to spare.
constexpr uint64_t kFewestSteps = 3 * kTrialSteps;
// Rates stay if lower ones are not clearly better: a trial shows only the beginning [dB].
constexpr double kClearGain = 1;
// A good start may lose a little by any step, and wins it back.
constexpr double kSmallLoss = 0.2;
constexpr double kLeastShare = 1e-4;

}  // namespace

bool RateTrial::Advance() {
  if (steps_.iteration() > 0 || pictures_.learns_all()) return false;
  if (options_.iterations > 0 && options_.iterations < kFewestSteps) return false;
  const double start = pictures_.JudgeField().psnr;
  const FieldState before = field_.ReadState();
  const double given = TrialPsnr(1);
  double share = 1, psnr = given;
  if (given < start - kClearGain) {
    const FieldState after = field_.ReadState();
    while (psnr < start - kSmallLoss && share > kLeastShare) {
      field_.PutState(before);
      share /= 10;
      psnr = TrialPsnr(share);
    }
    if (psnr < given + kClearGain) {
      field_.PutState(after);
      share = 1;
    }
  }
  steps_.UseShareOfRates(share);
  steps_.CountTried(kTrialSteps);
  if (share < 1) {
    LogWarning(
        "the learning rates are too high: after {} steps with them the judging pictures show "
        "{:.1f} dB, and {:.1f} dB before; a share of {:.0e} of the rates of colour and density is "
        "used, "
        "which shows {:.1f} dB",
        kTrialSteps, given, start, share, psnr);
  }
  return true;
}

double RateTrial::TrialPsnr(double share) {
  steps_.UseShareOfRates(share);
  steps_.Try(kTrialSteps, AtProgress(0));
  return pictures_.JudgeField().psnr;
}

}  // namespace tetrec
