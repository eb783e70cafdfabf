// Data-parallel loops on all cores.
#pragma once

#include <cstddef>
#include <functional>

namespace tetrec {

// Calls body(begin, end) on disjoint ranges that cover [0, count), on all cores. Ranges depend only
// on count, so results do not depend on the number of threads when bodies are independent. The
// first exception thrown by a body is rethrown.
void ParallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body);

}  // namespace tetrec
