// The schedule of a run, as functions of its progress in [0, 1].
#include "optimize/schedule.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

namespace {

// Learning rates fall to this share in a whole run, were it not for the fast fall at its end.
constexpr double kSlowFall = 0.2;
constexpr double kFastFall = 0.75;  // the progress at which it begins

constexpr double kUsualGrowth = 4.0 / 3.0;
constexpr int kFewestRounds = 3, kMostRounds = 9;

}  // namespace

double RateShare(const ScheduleOptions& options, double progress) {
  const double at = std::clamp(progress, 0.0, 1.0);
  const double slow_end = std::max(kSlowFall, options.final_rate_share);
  const double fast = std::max(0.0, at - kFastFall) / (1.0 - kFastFall);
  return std::pow(slow_end, at) * (1.0 - fast * (1.0 - options.final_rate_share / slow_end));
}

int SamplesPerSide(const ScheduleOptions& options, double progress, double rays) {
  return progress >= options.fine_rays && rays >= options.rays_before_fine ? 2 : 1;
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
  const double by_time = 180e3 * std::pow(seconds / 120.0, 0.4);
  return uint64_t(std::min(by_time, double(pixels) / 16.0));
}

}  // namespace tetrec
