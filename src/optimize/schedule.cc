// The schedule of a run, as functions of its progress, steps and growth.
#include "optimize/schedule.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

namespace {

constexpr double kFastFall = 0.75;    // progress or growth at which rates begin to fall fast
constexpr double kFinalOfSlow = 0.1;  // what is left of them at the end of the run
constexpr double kGrownOfSlow = 0.5;  // what is left of them at the end of growth, in a long run

// The share of the rates after some steps without the fast fall.
double SlowFall(uint64_t steps) { return std::pow(1.0 + double(steps) / 800.0, -0.95); }

// From 1 to `last` in the last quarter.
double FastFall(double at, double last) {
  const double fallen = std::clamp((at - kFastFall) / (1.0 - kFastFall), 0.0, 1.0);
  return 1.0 - fallen * (1.0 - last);
}

// Vertices that kGrowthSeconds afford, and how they become more with time.
constexpr double kVerticesOfGrowth = 110e3, kExponentOfVertices = 0.3;

constexpr double kUsualGrowth = 4.0 / 3.0;
constexpr int kFewestRounds = 3, kMostRounds = 9;
constexpr double kLeastLateFactor = 1.05;     // less is not worth a late round
constexpr double kLengthPerLateRound = 2.24;  // two late rounds in ten minutes

int UsualRounds(double factor) {
  return int(std::ceil(std::log(std::max(factor, 1.0)) / std::log(kUsualGrowth)));
}

int LateRounds(double factor, double length) {
  return std::max(factor > kLeastLateFactor ? UsualRounds(factor) : 0,
                  int(std::lround(std::log(length) / std::log(kLengthPerLateRound))));
}

}  // namespace

double RateShare(const ScheduleOptions& options, const RunMoment& moment, uint64_t steps) {
  if (options.final_rate_share) {
    return std::pow(*options.final_rate_share, std::clamp(moment.progress, 0.0, 1.0));
  }
  return SlowFall(steps) *
         std::min(FastFall(moment.progress, kFinalOfSlow), FastFall(moment.growth, kGrownOfSlow));
}

std::vector<PlannedRound> PlanGrowth(const ScheduleOptions& options, uint64_t vertices,
                                     uint64_t growth_vertices, uint64_t max_vertices,
                                     double length) {
  const bool is_given = options.rounds.has_value();
  const double start = double(std::max<uint64_t>(vertices, 1));
  const double factor = double(is_given ? max_vertices : growth_vertices) / start;
  const double last = is_given ? options.last_round * length : options.last_round;
  const int count =
      options.rounds.value_or(std::clamp(UsualRounds(factor), kFewestRounds, kMostRounds));
  std::vector<PlannedRound> plan;
  for (int round = 1; round <= count; ++round) {
    const double share = double(round) / count;
    plan.push_back(
        {last * std::pow(share, 1.7), uint64_t(std::round(start * std::pow(factor, share)))});
  }
  if (is_given || length <= 1.0) return plan;
  const double late_factor = double(max_vertices) / (start * factor);
  const int late = LateRounds(late_factor, length);
  for (int round = 1; round <= late; ++round) {
    const double share = double(round) / late;
    plan.push_back({last * std::pow(length, share),
                    uint64_t(std::round(start * factor * std::pow(late_factor, share))), true});
  }
  return plan;
}

double RoundGrowth(const PlannedRound& round, uint64_t vertices) {
  return std::clamp(double(round.vertices) / double(std::max<uint64_t>(vertices, 1)), 1.0, 2.5);
}

uint64_t AffordableVertices(double seconds, uint64_t subject_pixels) {
  const double by_time =
      kVerticesOfGrowth * std::pow(seconds / kGrowthSeconds, kExponentOfVertices);
  return uint64_t(std::min(by_time, double(subject_pixels) / kPixelsPerVertex));
}

double SecondsForVertices(double vertices) {
  return kGrowthSeconds * std::pow(vertices / kVerticesOfGrowth, 1.0 / kExponentOfVertices);
}

}  // namespace tetrec
