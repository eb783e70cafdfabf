// The hold-out rule.
#include "scene/split.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {

void CheckHoldout(int every) {
  constexpr int kMost = 1000000;
  if (every >= 0 && every != 1 && every <= kMost) return;
  throw UsageError(
      fmt::format("holdout is {}; expected 0 (hold out no view) or 2 to {} (hold out every N-th)",
                  every, kMost));
}

bool IsHeldOut(size_t place, int every) { return every > 0 && place % size_t(every) == 0; }

}  // namespace tetrec
