// Peak memory, as the kernel accounts for it.
#include "core/process_memory.h"

#include <sys/resource.h>

#include <algorithm>

namespace tetrec {

uint64_t PeakRssBytes() {
  uint64_t peak = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    peak = std::max(peak, uint64_t(usage.ru_maxrss) * 1024);
  }
  return peak;
}

}  // namespace tetrec
