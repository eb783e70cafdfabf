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
// camera has spoilt takes longer to mend than other trials take. In the shortest runs it would take
// a large share of the steps.
constexpr uint64_t kPartOfTrial = 8, kFewestSteps = kFewestTrialSteps, kMostSteps = 300;
constexpr uint64_t kFewestStepsBefore = 4 * kFewestSteps;

// No other photo judges what only one shows, and without it the others are learned more often: so a
// small gain does not suffice.
constexpr double kLeastGain_db = 0.05, kLeastStandardErrors = 2;
constexpr size_t kFewestJudges = 2;  // views, or there is no standard error

std::vector<uint8_t> FlagsOf(std::span<const size_t> views, size_t count) {
  std::vector<uint8_t> flags(count, 0);
  for (const size_t view : views) flags[view] = 1;
  return flags;
}

}  // namespace

std::vector<size_t> FindStray(std::span<const ErrorSum> views) {
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
  const double limit = median + std::max(std::log(kLeastErrorRatio), kLeastDeviations * deviation);
  std::vector<size_t> stray;
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i].rays >= kFewestRays && log_of(views[i]) > limit) stray.push_back(i);
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
  const std::vector<uint8_t> left_out_before = state_.left_out;
  const std::vector<ErrorSum> errors = pictures_.ErrorsOfViews();
  const std::vector<uint8_t> stray = FlagsOf(FindStray(errors), errors.size());
  const bool is_changed = LearnWhatFitsAgain(stray);
  const bool finds_another = std::ranges::count(stray, 1) > CountLeftOut();
  const std::optional<bool> is_better =
      finds_another ? IsBetterWithout(stray) : std::optional(false);
  if (!is_better) {  // stopped: the resumed run looks again
    state_.left_out = left_out_before;
    pictures_.LeaveOut(state_.left_out);
    return false;
  }
  ++state_.looks;
  if (*is_better) state_.left_out = stray;
  return is_changed || *is_better;
}

ptrdiff_t StrayPhotos::CountLeftOut() const { return std::ranges::count(state_.left_out, 1); }

bool StrayPhotos::LearnWhatFitsAgain(const std::vector<uint8_t>& stray) {
  const ptrdiff_t before = CountLeftOut();
  for (size_t view = 0; view < state_.left_out.size(); ++view) state_.left_out[view] &= stray[view];
  const ptrdiff_t again = before - CountLeftOut();
  if (again == 0) return false;
  LogInfo("photos that fit the others now and are learned again: {}", again);
  pictures_.LeaveOut(state_.left_out);
  return true;
}

std::optional<bool> StrayPhotos::IsBetterWithout(const std::vector<uint8_t>& stray) {
  const uint64_t steps = std::clamp(steps_.iteration() / kPartOfTrial, kFewestSteps, kMostSteps);
  FieldTrial trial(field_, steps_, steps);
  if (!trial.Train()) return {};
  FieldState trained = field_.ReadState();
  // The others judge both fields.
  pictures_.LeaveOut(stray);
  const Judgement with = pictures_.JudgeField();
  if (!trial.Train()) return {};
  const Judgement without = pictures_.JudgeField();
  trial.CountSteps();
  const JudgedGain gain = GainBetween(with.views, without.views);
  const bool is_better = with.views.size() >= kFewestJudges && gain.gain > kLeastGain_db &&
                         gain.gain > kLeastStandardErrors * gain.standard_error;
  LogInfo(
      "photos that do not fit the others: {}; without them, the others change by {:+.2f} dB after "
      "{} steps, standard error {:.2f}: they {}",
      std::ranges::count(stray, 1), gain.gain, steps, gain.standard_error,
      is_better ? "are left out" : "stay");
  if (!is_better) {
    pictures_.LeaveOut(state_.left_out);
    field_.PutState(std::move(trained));
  }
  return is_better;
}

}  // namespace tetrec
