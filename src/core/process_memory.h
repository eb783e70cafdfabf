// The peak of memory, and memory given back to the system.
#pragma once

#include <cstdint>

namespace tetrec {

// The largest resident set of this process or of any child that has ended.
uint64_t PeakRssBytes();

// From now on, large blocks go back to the system as soon as they are freed. By default glibc keeps
// ever larger ones in its heap, where meshes of earlier refinements leave holes: 17 % of the peak
// of tetrec-optimize.
void ReturnLargeBlocksWhenFreed();

// Gives back to the system what has been freed in small blocks, where whole pages are free. The
// driver's compiler of kernels and CGAL leave many such blocks.
void ReturnFreedMemory();

}  // namespace tetrec
