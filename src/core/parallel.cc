// Ranges handed out to threads from one counter.
#include "core/parallel.h"

#include "core/progress.h"
#include "core/stop_request.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace tetrec {

void ParallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) {
  grain = std::max<size_t>(grain, 1);
  const size_t ranges = count / grain + (count % grain != 0);
  std::atomic<size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::exception_ptr first;

  const auto work = [&] {
    for (size_t i = next++; i < ranges && !failed; i = next++) {
      try {
        body(i * grain, std::min(count, (i + 1) * grain));
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!first) first = std::current_exception();
        failed = true;
      }
    }
  };

  // Asked once: the system reads a file to answer.
  static const size_t cores = std::max(1u, std::thread::hardware_concurrency());
  {
    std::vector<std::jthread> helpers;
    try {
      for (size_t t = 1; t < std::min(cores, ranges); ++t) helpers.emplace_back(work);
    } catch (const std::system_error&) {
      // The system starts no more threads (a limit on processes): those that there are do the work.
    }
    work();
  }
  if (first) std::rethrow_exception(first);
}

void ParallelForEach(size_t count, const std::string& title, const std::string& saved,
                     const std::function<void(size_t)>& body) {
  std::optional<Progress> progress;
  if (!title.empty()) progress.emplace(title, double(count));
  std::mutex mutex;
  size_t done = 0;
  ParallelFor(count, 1, [&](size_t i, size_t) {
    ThrowIfStopRequested(saved);
    body(i);
    const std::scoped_lock lock(mutex);
    ++done;
    if (progress) progress->Update(double(done));
  });
}

}  // namespace tetrec
