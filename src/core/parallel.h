// Data-parallel loops on all cores.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace tetrec {

// Calls body(begin, end) on disjoint ranges that cover [0, count), on all cores. Ranges depend only
// on count and grain, so results do not depend on the number of threads when bodies are
// independent. The first exception thrown by a body is rethrown.
void ParallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body);

// For long work in independent pieces, such as one image each: calls body(i) for every i below
// `count` on all cores, smaller ones first. Shows progress under `title`, or none if that is empty.
// After a request to stop no further call starts, and Interrupted is thrown: `saved` states what is
// kept, for its message.
void ParallelForEach(size_t count, const std::string& title, const std::string& saved,
                     const std::function<void(size_t)>& body);

}  // namespace tetrec
