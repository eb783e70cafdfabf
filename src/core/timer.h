// A wall-clock timer.
#pragma once

#include <chrono>

namespace tetrec {

// Runs from its construction on.
class Timer {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace tetrec
