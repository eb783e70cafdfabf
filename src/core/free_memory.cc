// Free memory of the host, as Linux reports it.
#include "core/free_memory.h"

#include <fstream>
#include <limits>

namespace tetrec {
namespace {

// The value of a line "NAME:  123 kB" of /proc/meminfo; the largest number if there is no such
// line.
uint64_t MemInfoBytes(const std::string& name) {
  std::ifstream file("/proc/meminfo");
  std::string word;
  while (file >> word) {
    uint64_t kib = 0;
    if (word == name + ":" && file >> kib) return kib << 10;
  }
  return std::numeric_limits<uint64_t>::max();
}

}  // namespace

FreeMemory MeasureFreeHostMemory() { return {MemInfoBytes("MemAvailable"), "the host"}; }

}  // namespace tetrec
