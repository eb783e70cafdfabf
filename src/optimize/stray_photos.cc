// Photos that do not fit the others.
#include "optimize/stray_photos.h"

#include "core/error.h"
#include "core/log.h"
#include "core/quantile.h"
#include "optimize/field_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// The growth of a run at each look. The first one follows the first sweeps over the cameras; later
// ones find what a sharper field shows.
constexpr std::array kLooks = {0.25, 0.4, 0.6};
static_assert(kLooks.back() < ScheduleOptions().last_judging);

constexpr size_t kFewestToCompare = 8;
constexpr double kFewestRays = 128;  // of a view
constexpr double kLeastErrorRatio = 4, kLeastDeviations = 4;
constexpr double kDeviationPerMedian = 1.4826;  // of a normal distribution

// The trial takes this part of the steps so far, in each of both ways: what a photo of a wrong
// camera has spoilt takes longer to mend than other trials take. But where it does not show after
// 120 steps, among many photos, it spoils little. In the shortest runs a trial would take a large
// share of the steps.
constexpr uint64_t kPartOfTrial = 8, kFewestSteps = kFewestTrialSteps, kMostSteps = 120;
constexpr uint64_t kFewestStepsBefore = 4 * kFewestSteps;

// No other photo judges what only one shows, and without it the others are learned more often: so a
// small gain does not suffice.
constexpr double kLeastGain_db = 0.05, kLeastStandardErrors = 2;
constexpr size_t kFewestJudges = 2;  // views, or there is no standard error

// A photo that stays after a trial is tried again once its error has grown so much against the
// others. In a short run on fox, that of a camera turned by 5 degrees is 13, 19 and 38 times the
// median at the three looks, so that it is tried each time; on lego, that of a glint, which belongs
// to the subject, is 8, 12 and 13 times, so that the third trial is spared.
constexpr double kGrownRatio = 1.3;

}  // namespace

std::vector<StrayView> FindStray(std::span<const ErrorSum> views) {
  const auto log_of = [](const ErrorSum& view) {
    return std::log(std::max(view.squares / view.rays, 1e-12));
  };
  std::vector<double> logs, deviations;
  for (const ErrorSum& view : views) {
    if (view.rays >= kFewestRays) logs.push_back(log_of(view));
  }
  if (logs.size() < kFewestToCompare) return {};
  const double median = Median(logs);
  for (const double value : logs) deviations.push_back(std::abs(value - median));
  const double deviation = kDeviationPerMedian * Median(deviations);
  const double limit = std::max(std::log(kLeastErrorRatio), kLeastDeviations * deviation);
  std::vector<StrayView> stray;
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i].rays < kFewestRays) continue;
    const double above = log_of(views[i]) - median;
    if (above > limit) stray.push_back({i, std::exp(above)});
  }
  return stray;
}

void StrayPhotos::Resume(StrayState state, const std::string& checkpoint) {
  const size_t photos = pictures_.set().views.size();
  if (!state.left_out.empty() && state.left_out.size() != photos) {
    throw DataError(
        fmt::format("{}: was written for {} photos, but the scene has {}; force a "
                    "fresh run",
                    checkpoint, state.left_out.size(), photos));
  }
  state_ = std::move(state);
  pictures_.LeaveOut(state_.left_out);
}

bool StrayPhotos::IsDue(double growth) const {
  return options_.stray_photos == StrayChoice::kAuto && state_.looks < kLooks.size() &&
         growth >= kLooks[state_.looks];
}

bool StrayPhotos::Advance() {
  if (pictures_.learns_all() || steps_.iteration() < kFewestStepsBefore) {
    ++state_.looks;
    return false;
  }
  const StrayState before = state_;
  const std::vector<ErrorSum> errors = pictures_.ErrorsOfViews();
  state_.left_out.resize(errors.size());
  state_.tried_ratio.resize(errors.size());
  const std::vector<StrayView> stray = FindStray(errors);
  const bool is_changed = LearnWhatFitsAgain(stray);
  std::vector<uint8_t> left_out = state_.left_out;
  for (const StrayView& one : stray) {
    if (!IsAcquitted(one)) left_out[one.view] = 1;
  }
  const std::optional<bool> is_better =
      left_out != state_.left_out ? IsBetterWithout(left_out) : std::optional(false);
  if (!is_better) {  // stopped: the resumed run looks again
    state_ = before;
    pictures_.LeaveOut(state_.left_out);
    return false;
  }
  for (const StrayView& one : stray) {
    if (left_out[one.view] == state_.left_out[one.view]) continue;
    state_.tried_ratio[one.view] = *is_better ? 0.0f : float(one.error_ratio);
  }
  if (*is_better) state_.left_out = left_out;
  ++state_.looks;
  return is_changed || *is_better;
}

ptrdiff_t StrayPhotos::CountLeftOut() const { return std::ranges::count(state_.left_out, 1); }

bool StrayPhotos::LearnWhatFitsAgain(std::span<const StrayView> stray) {
  std::vector<uint8_t> still(state_.left_out.size(), 0);
  for (const StrayView& one : stray) still[one.view] = state_.left_out[one.view];
  if (still == state_.left_out) return false;
  const ptrdiff_t before = CountLeftOut();
  state_.left_out = std::move(still);
  LogInfo("photos that fit the others now and are learned again: {}", before - CountLeftOut());
  pictures_.LeaveOut(state_.left_out);
  return true;
}

bool StrayPhotos::IsAcquitted(const StrayView& stray) const {
  return stray.error_ratio < kGrownRatio * double(state_.tried_ratio[stray.view]);
}

std::optional<bool> StrayPhotos::IsBetterWithout(const std::vector<uint8_t>& left_out) {
  const uint64_t steps = std::clamp(steps_.iteration() / kPartOfTrial, kFewestSteps, kMostSteps);
  FieldTrial trial(field_, steps_, steps);
  if (!trial.Train()) return {};
  // The others judge both fields.
  pictures_.LeaveOut(left_out);
  const Judgement with = pictures_.JudgeField();
  if (!trial.Train()) return {};
  const Judgement without = pictures_.JudgeField();
  trial.TakeBack();
  const JudgedGain gain = GainBetween(with.views, without.views);
  const bool is_better = with.views.size() >= kFewestJudges && gain.gain > kLeastGain_db &&
                         gain.gain > kLeastStandardErrors * gain.standard_error;
  LogInfo(
      "photos that do not fit the others: {}; without them, the others change by {:+.2f} dB after "
      "{} steps, standard error {:.2f}: they {}",
      std::ranges::count(left_out, 1), gain.gain, steps, gain.standard_error,
      is_better ? "are left out" : "stay");
  if (!is_better) pictures_.LeaveOut(state_.left_out);
  return is_better;
}

}  // namespace tetrec
