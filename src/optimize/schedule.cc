// The schedule of a run, as functions of its progress in [0, 1].
#include "optimize/schedule.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

double RateShare(const ScheduleOptions& options, double progress) {
  return std::pow(options.final_rate_share, std::clamp(progress, 0.0, 1.0));
}

double RoundProgress(const ScheduleOptions& options, int round) {
  return options.last_round * std::pow(double(round + 1) / options.rounds, 1.7);
}

double RoundGrowth(const ScheduleOptions& options, int round, uint64_t vertices,
                   uint64_t max_vertices) {
  const int left = std::max(1, options.rounds - round);
  const double growth =
      std::pow(double(max_vertices) / double(std::max<uint64_t>(vertices, 1)), 1.0 / left);
  return std::clamp(growth, 1.0, 2.5);
}

uint64_t AffordableVertices(double seconds, uint64_t pixels) {
  const double by_time = 180e3 * std::pow(seconds / 120.0, 0.4);
  return uint64_t(std::min(by_time, double(pixels) / 16.0));
}

}  // namespace tetrec
