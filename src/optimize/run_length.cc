// How long a run will be, and what it therefore affords.
#include "optimize/run_length.h"

#include "optimize/mesh_budget.h"

#include <algorithm>
#include <limits>

namespace tetrec {

namespace {

double VerticesWithin(uint64_t max_tets) {
  return max_tets == kNoBudget ? std::numeric_limits<double>::infinity()
                               : double(max_tets) / kTetsPerVertex;
}

}  // namespace

uint64_t AffordingPixels(const TrainingSet& set, const TetMesh& start) {
  return std::max(SubjectPixels(set), uint64_t(kPixelsPerVertex) * start.positions.size());
}

RunLength LengthOf(const OptimizeOptions& options, const DevicePace& pace,
                   uint64_t affording_pixels, uint64_t max_tets) {
  const double rays_of_two_cores = DevicePace().rays_per_step;
  const double larger_steps = std::max(1.0, options.RaysPerStep(pace) / rays_of_two_cores);
  if (!options.HasLimit()) {
    const double vertices = options.max_vertices > 0 ? double(options.max_vertices)
                                                     : double(affording_pixels) / kPixelsPerVertex;
    const double seconds = SecondsForVertices(std::min(vertices, VerticesWithin(max_tets)));
    return {seconds / larger_steps, seconds};
  }
  const RunLength by_time{options.time_limit_s, options.time_limit_s * pace.speed};
  const double seconds = double(options.iterations) / kStepsPerSecond;
  const RunLength by_iterations{seconds, seconds * larger_steps};
  if (options.time_limit_s <= 0) return by_iterations;
  if (options.iterations == 0) return by_time;
  return {std::min(by_time.seconds, by_iterations.seconds),
          std::min(by_time.seconds_of_two_cores, by_iterations.seconds_of_two_cores)};
}

uint64_t MaxVertices(const OptimizeOptions& options, const RunLength& length,
                     uint64_t affording_pixels, uint64_t max_tets) {
  uint64_t vertices = options.max_vertices;
  if (vertices == 0 && options.budget == BudgetChoice::kAuto) {
    vertices = AffordableVertices(length.seconds_of_two_cores, affording_pixels);
  }
  if (max_tets == kNoBudget) return vertices;
  const uint64_t in_budget = uint64_t(VerticesWithin(max_tets));
  return vertices == 0 ? in_budget : std::min(vertices, in_budget);
}

std::vector<PlannedRound> PlanRounds(const OptimizeOptions& options, const RunLength& length,
                                     uint64_t start_vertices, uint64_t max_vertices,
                                     uint64_t affording_pixels) {
  // In a run without limits, a given number of rounds is done while it is young.
  const bool is_brief = !options.HasLimit() && options.schedule.rounds;
  const double seconds = is_brief ? kGrowthSeconds : length.seconds;
  const double share_of_growth = std::min(seconds, kGrowthSeconds) / length.seconds;
  const uint64_t growth_vertices =
      AffordableVertices(length.seconds_of_two_cores * share_of_growth, affording_pixels);
  return PlanGrowth(
      options.schedule, start_vertices,
      seconds > kGrowthSeconds ? std::min(growth_vertices, max_vertices) : max_vertices,
      max_vertices, std::max(1.0, seconds / kGrowthSeconds));
}

}  // namespace tetrec
