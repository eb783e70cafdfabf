// Memory that there is, for those who refuse early what would not fit.
#pragma once

#include <cstdint>
#include <string>

namespace tetrec {

struct FreeMemory {
  uint64_t bytes = 0;
  std::string of;  // "device 'NAME'", "the host"
};

// What the host can give away without swapping; as much as there can be where it does not tell.
FreeMemory MeasureFreeHostMemory();

}  // namespace tetrec
