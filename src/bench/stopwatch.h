// Wall time and CPU time of a piece of work, and the middle of many.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace tetrec {

// Of the process, all threads (a software device's too).
inline double ProcessCpuSeconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

struct Seconds {
  double wall = 0, cpu = 0;
};

template <class Body>
Seconds Measure(const Body& body) {
  const double cpu = ProcessCpuSeconds();
  const auto wall = std::chrono::steady_clock::now();
  body();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count(),
          ProcessCpuSeconds() - cpu};
}

// The upper one of two in the middle; of none 0.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace tetrec
