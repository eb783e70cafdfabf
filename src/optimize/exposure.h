// The exposures of the training photos, estimated together with the field.
#pragma once

#include "core/words.h"
#include "render/exposure.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

enum class ExposureMode {
  kAuto,  // for photos without alpha
  kOn,
  kOff,
};
template <>
inline constexpr auto kWords<ExposureMode> = std::to_array<Word<ExposureMode>>(
    {{ExposureMode::kAuto, "auto"}, {ExposureMode::kOn, "on"}, {ExposureMode::kOff, "off"}});

// What a resumed run needs. Empty if exposures are not estimated; otherwise one of each per
// training view.
struct ExposureState {
  std::vector<ViewExposure> exposures;
  std::vector<ExposureSums> sums;  // of the recent steps
};

// The exposures of the views by least squares on their sums, with a weak pull towards neutral for
// views that are seen little or show one colour.
std::vector<ViewExposure> FitExposures(std::span<const ExposureSums> sums);

// Gives all views together the neutral exposure: the median of the logarithms of the gains and the
// median of the offsets become 0 in each channel. Otherwise field and exposures could drift apart
// (a brighter field, darker exposures) at no cost. A mean would follow one black or flash-lit
// photo, and with it the brightness of the field in all unseen views.
void MakeMedianNeutral(std::span<ViewExposure> exposures);

// Shrinks all exposures towards neutral by what their spread is expected to be if there is nothing
// to correct (James and Stein's rule with the positive part): a collection of even exposure ends
// with exactly neutral ones.
void ShrinkToEvidence(std::span<ViewExposure> exposures);

// Keeps the exposures of a run. They are fitted every kFitInterval steps once the picture has
// partly converged.
class ExposureEstimate {
 public:
  ExposureEstimate() = default;  // estimates nothing
  explicit ExposureEstimate(size_t views);
  explicit ExposureEstimate(ExposureState state) : state_(std::move(state)) {}

  bool is_on() const { return !state_.exposures.empty(); }
  // True if a step at this growth of the run (schedule.h) should gather sums.
  bool Gathers(double growth) const;
  // True if it is time to fit after `iteration` steps.
  bool IsFitDue(uint64_t iteration, double growth) const;
  // Takes the sums and gives new exposures.
  void Fit(TrainingRenderer& renderer);
  // The state after all steps so far. Waits for those in flight.
  const ExposureState& State(TrainingRenderer& renderer);

 private:
  ExposureState state_;
};

}  // namespace tetrec
