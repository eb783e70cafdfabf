// Wall time and CPU time of a piece of work, and medians of such times.
#pragma once

#include "core/quantile.h"
#include "core/timer.h"

#include <sys/resource.h>

#include <utility>
#include <vector>

namespace tetrec {

// CPU time of all threads of the process, those of a software device included.
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
  const Timer wall;
  body();
  return {wall.seconds(), ProcessCpuSeconds() - cpu};
}

// The upper of the two middle values if their number is even; 0 without any.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const size_t middle = values.size() / 2;
  return ValueOfRank(std::move(values), middle);
}

}  // namespace tetrec
