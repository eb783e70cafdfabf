// View-dependent colour in a run: unlocked degree by degree, and kept after a trial.
#include "optimize/harmonics_trials.h"

#include "core/log.h"
#include "render/seen_colors.h"

namespace tetrec {

bool HarmonicsTrials::Advance(double growth) {
  const HarmonicsStep step = NextHarmonicsStep(options_.harmonics, state_, growth);
  if (step == HarmonicsStep::kUnlock) Unlock();
  if (step == HarmonicsStep::kJudge) Judge();
  return step != HarmonicsStep::kNone;
}

void HarmonicsTrials::Unlock() {
  if (options_.harmonics == HarmonicsChoice::kAuto) {
    const char* why_not = pictures_.learns_all() ? "no judging pictures are kept that could tell"
                          : steps_.iteration() < kFewestTrialSteps ? "the run is too short to tell"
                                                                   : nullptr;
    if (why_not != nullptr) {
      LogInfo("colours do not depend on the view: {}", why_not);
      state_.closed = 1;
      return;
    }
  }
  ++state_.unlocked;
  field_.PutState(WithHarmonics(field_.ReadState(), field_.harmonics_degree() + 1));
  LogInfo("colours depend on the view by harmonics of degree {}", field_.harmonics_degree());
}

// Trains on with the highest degree and without it, by the same batches, and keeps the better.
void HarmonicsTrials::Judge() {
  state_.judged = state_.unlocked;
  if (pictures_.learns_all()) return;  // too late to judge: the degree stays
  const int degree = field_.harmonics_degree();
  const uint64_t steps = TrialSteps(steps_.iteration());
  const FieldState before = field_.ReadState();
  const double with = TrialPsnr(steps);
  FieldState trained = field_.ReadState();
  field_.PutState(WithoutHighestDegree(field_.mesh(), before, field_.sight()));
  const double without = TrialPsnr(steps);
  const bool stays = IsWorthHarmonics(with, without);
  LogInfo(
      "judging pictures after {} steps: {:.2f} dB with harmonics of degree {}, {:.2f} dB without: "
      "{}",
      steps, with, degree, without, stays ? "they stay" : "they are dropped");
  if (stays) field_.PutState(std::move(trained));
  if (!stays) state_.closed = 1;
  steps_.CountTried(steps);
}

double HarmonicsTrials::TrialPsnr(uint64_t steps) {
  steps_.Try(steps, kRatesOfTrials);
  return pictures_.JudgeField().psnr;
}

}  // namespace tetrec
