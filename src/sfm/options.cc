// The options of structure from motion.
#include "sfm/options.h"

#include "core/error.h"
#include "core/option_range.h"
#include "scene/subject_bounds.h"
#include "sfm/photos.h"

#include <fmt/format.h>

namespace tetrec {

void SfmOptions::Check() const {
  CheckRange("frames", frames, int(kFewestPhotos), 2000);
  CheckRange("max-features", max_features, 100, 100000);
  CheckRange("retries", retries, 0, 3);
  if (!(max_unreadable >= 0 && max_unreadable < 1)) {
    throw UsageError(
        fmt::format("max-unreadable is {}; expected at least 0 and less than 1", max_unreadable));
  }
  CheckRange("max-size", max_size, 16, 16384);
  if (bounds_in_found_world) CheckGivenBounds(*bounds_in_found_world);
  CheckHoldout(holdout);
  CheckRange("train-every", train_every, 1, 1000000);
  CheckRange("seed", seed, 0, 1 << 30);
}

}  // namespace tetrec
