// The schedule of a run, as functions of its progress in [0, 1].
#include "optimize/schedule.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

namespace {

constexpr double kFastFall = 0.75;    // the progress at which rates begin to fall fast
constexpr double kFinalOfSlow = 0.1;  // what the fast fall leaves of them

// The share to which rates would fall in a whole run without the fast fall. On lego, 0.2 gains 0.7
// dB against 0.05 after 1,200 steps and 0.2 dB after 4,000; on the demo it gains 0.3 dB after 800
// and loses 0.14 dB after 6,000.
double SlowFall(double steps) {
  return std::clamp(0.2 * std::pow(1500.0 / std::max(steps, 1.0), 0.7), 0.03, 0.3);
}

constexpr double kUsualGrowth = 4.0 / 3.0;
constexpr int kFewestRounds = 3, kMostRounds = 9;

}  // namespace

double RateShare(const ScheduleOptions& options, double progress, double steps) {
  const double at = std::clamp(progress, 0.0, 1.0);
  if (options.final_rate_share) return std::pow(*options.final_rate_share, at);
  const double fast = std::max(0.0, at - kFastFall) / (1.0 - kFastFall);
  return std::pow(SlowFall(steps), at) * (1.0 - fast * (1.0 - kFinalOfSlow));
}

GrowthPlan PlanGrowth(const ScheduleOptions& options, uint64_t vertices, uint64_t max_vertices) {
  const double factor = double(max_vertices) / double(std::max<uint64_t>(vertices, 1));
  const double rounds = std::ceil(std::log(std::max(factor, 1.0)) / std::log(kUsualGrowth));
  return {options.rounds.value_or(std::clamp(int(rounds), kFewestRounds, kMostRounds)),
          max_vertices};
}

double RoundProgress(const ScheduleOptions& options, const GrowthPlan& plan, int round) {
  return options.last_round * std::pow(double(round + 1) / plan.rounds, 1.7);
}

double RoundGrowth(const GrowthPlan& plan, int round, uint64_t vertices) {
  const int left = std::max(1, plan.rounds - round);
  const double factor = double(plan.max_vertices) / double(std::max<uint64_t>(vertices, 1));
  return std::clamp(std::pow(factor, 1.0 / left), 1.0, 2.5);
}

uint64_t AffordableVertices(double seconds, uint64_t pixels) {
  const double by_time = 110e3 * std::pow(seconds / 120.0, 0.3);
  return uint64_t(std::min(by_time, double(pixels) / 16.0));
}

}  // namespace tetrec
