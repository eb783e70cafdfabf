// The peak of memory, and memory given back to the system.
#include "core/process_memory.h"

#include <sys/resource.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

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

void ReturnLargeBlocksWhenFreed() {
#ifdef __GLIBC__
  constexpr int kLargeBlock = 1 << 20;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLargeBlock);
#endif
}

void ReturnFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace tetrec
