// Photos that do not fit the others: their cameras were found in wrong places, or what they show
// has moved. They blur what the others show, so they are left out if the others gain by it.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/judging.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct StrayView {
  size_t view;
  double error_ratio;  // of its mean squared error to the median of all views
  bool operator==(const StrayView&) const = default;
};

// The views that do not fit: those whose mean squared error is at least four times the median, and
// more than four standard deviations (of the logarithms, estimated from their median deviation)
// above it. Views with fewer than 128 rays are not compared, nor are fewer than 8 views.
std::vector<StrayView> FindStray(std::span<const ErrorSum> views);

struct StrayState {
  uint32_t looks = 0;  // done
  // Per training view; both are empty before the first look.
  std::vector<uint8_t> left_out;
  std::vector<float> tried_ratio;  // error ratio when a trial last let it stay; 0: none did
};

class StrayPhotos {
 public:
  StrayPhotos(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
              TrainingSteps& steps)
      : options_(options), field_(field), pictures_(pictures), steps_(steps) {}

  // Must be called before the cameras are placed. Throws DataError that names `checkpoint` if the
  // state is of another number of photos.
  void Resume(StrayState state, const std::string& checkpoint);
  const StrayState& state() const { return state_; }

  bool IsDue(double growth) const;
  // Looks for photos that do not fit, and tries what the others gain without them; those that were
  // left out and fit now are learned again. Returns true if the photos that are left
  // out have changed: judgements before and after cannot be compared then. If the run is asked to
  // stop meanwhile, everything is as before.
  bool Advance();

 private:
  ptrdiff_t CountLeftOut() const;
  bool LearnWhatFitsAgain(std::span<const StrayView> stray);
  // A trial showed that the others gain nothing without it, and its error has hardly grown since.
  bool IsAcquitted(const StrayView& stray) const;
  // None if the run is asked to stop meanwhile.
  std::optional<bool> IsBetterWithout(const std::vector<uint8_t>& left_out);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  StrayState state_;
};

}  // namespace tetrec
