// Wall time and CPU time of a piece of work.
#pragma once

#include "core/timer.h"

#include <sys/resource.h>

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

}  // namespace tetrec
