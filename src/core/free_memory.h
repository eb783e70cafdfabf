// Available memory, so that work that would not fit can be refused early.
#pragma once

#include <cstdint>
#include <string>

namespace tetrec {

struct FreeMemory {
  uint64_t bytes = 0;
  std::string of;  // "device 'NAME'", "the host"
};

// What the host can provide without swapping; the largest number if that is unknown.
FreeMemory MeasureFreeHostMemory();

}  // namespace tetrec
