// View-dependent colour in a run: unlocked degree by degree, and kept where pictures gain by it.
#include "optimize/harmonics_trials.h"

#include "core/log.h"
#include "optimize/field_trial.h"
#include "render/seen_colors.h"

#include <optional>
#include <utility>

namespace tetrec {

bool HarmonicsTrials::Advance(double growth) {
  switch (NextHarmonicsStep(options_.harmonics, photos(), state_, growth)) {
    case HarmonicsStep::kNone:
      return false;
    case HarmonicsStep::kUnlock:
      Unlock();
      return true;
    case HarmonicsStep::kJudge:
      return Judge();
  }
  return false;
}

void HarmonicsTrials::Unlock() {
  if (options_.harmonics == HarmonicsChoice::kAuto && IsJudged(state_.unlocked + 1)) {
    const char* why_not = pictures_.learns_all() ? "no judging pictures are kept that could tell"
                          : steps_.iteration() < kFewestTrialSteps ? "the run is too short to tell"
                                                                   : nullptr;
    if (why_not != nullptr) {
      LogInfo("harmonics end at degree {}: {}", state_.unlocked, why_not);
      state_.closed = 1;
      return;
    }
  }
  ++state_.unlocked;
  field_.PutState(WithHarmonics(field_.ReadState(), field_.harmonics_degree() + 1));
  LogInfo("colours depend on the view by harmonics of degree {}", field_.harmonics_degree());
}

bool HarmonicsTrials::Judge() {
  if (pictures_.learns_all()) {  // too late to judge: the degree stays
    state_.judged = state_.unlocked;
    return true;
  }
  const std::optional<bool> stays = HighestDegreeStays();
  if (!stays) return false;
  state_.judged = state_.unlocked;
  if (!*stays) state_.closed = 1;
  return true;
}

std::optional<bool> HarmonicsTrials::HighestDegreeStays() {
  const int degree = field_.harmonics_degree();
  const uint64_t steps = TrialSteps(steps_.iteration());
  FieldTrial trial(field_, steps_, steps);
  FieldState simpler = WithoutHighestDegree(field_.mesh(), trial.before(), field_.sight());
  const double now = pictures_.JudgeField().psnr;
  field_.PutState(simpler);
  const double taken_away = pictures_.JudgeField().psnr;
  trial.TakeBack();
  if (IsWorthHarmonics(now, taken_away)) {
    LogInfo("judging pictures: {:.2f} dB with harmonics of degree {}, {:.2f} dB without: they stay",
            now, degree, taken_away);
    return true;
  }
  if (!trial.Train()) return {};
  const double with = pictures_.JudgeField().psnr;
  if (!trial.TrainFrom(simpler)) return {};
  const double without = pictures_.JudgeField().psnr;
  const bool stays = IsWorthHarmonics(with, without);
  LogInfo(
      "judging pictures after {} steps: {:.2f} dB with harmonics of degree {}, {:.2f} dB without: "
      "{}",
      steps, with, degree, without, stays ? "they stay" : "they are dropped");
  if (stays) {
    trial.TakeBack();
  } else {
    field_.PutState(std::move(simpler));
  }
  return stays;
}

}  // namespace tetrec
