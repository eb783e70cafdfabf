// The memory that this process and its children have used.
#pragma once

#include <cstdint>

namespace tetrec {

// The largest resident set of this process or of any child that has ended.
uint64_t PeakRssBytes();

}  // namespace tetrec
