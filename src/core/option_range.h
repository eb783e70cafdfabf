// Bounds of the numbers in a struct of options. A message starts with the option's name, so that a
// command line can recognise its own option in it.
#pragma once

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {

// Throws UsageError unless least <= value <= most; NaN is outside.
template <class T>
void CheckRange(const char* name, T value, T least, T most) {
  if (!(value >= least && value <= most))
    throw UsageError(fmt::format("{} is {}; expected {} to {}", name, value, least, most));
}

template <class T>
void CheckAtLeast(const char* name, T value, T least) {
  if (!(value >= least))
    throw UsageError(fmt::format("{} is {}; expected {} or more", name, value, least));
}

inline void CheckAboveZero(const char* name, double value) {
  if (!(value > 0))
    throw UsageError(fmt::format("{} is {}; expected a number above 0", name, value));
}

}  // namespace tetrec
