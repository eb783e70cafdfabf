// The options of structure from motion.
#include "sfm/options.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

void CheckRange(const char* option, int value, int min, int max) {
  if (value < min || value > max) {
    throw UsageError(fmt::format("{} is {}; expected {} to {}", option, value, min, max));
  }
}

}  // namespace

void SfmOptions::Check() const {
  CheckRange("frames", frames, 2, 2000);
  CheckRange("max-features", max_features, 100, 100000);
  CheckRange("retries", retries, 0, 3);
  CheckRange("max-size", max_size, 16, 16384);
  CheckHoldout(holdout);
  CheckRange("train-every", train_every, 1, 1000000);
  CheckRange("seed", seed, 0, 1 << 30);
}

}  // namespace tetrec
