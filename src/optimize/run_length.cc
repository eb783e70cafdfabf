// How long a run will be, and what it therefore affords.
#include "optimize/run_length.h"

#include "optimize/mesh_budget.h"

#include <algorithm>

namespace tetrec {

uint64_t AffordingPixels(const TrainingSet& set, const TetMesh& start) {
  return std::max(SubjectPixels(set), uint64_t(kPixelsPerVertex) * start.positions.size());
}

RunLength LengthOf(const OptimizeOptions& options, const DevicePace& pace,
                   uint64_t affording_pixels) {
  if (!options.HasLimit()) {
    const double vertices = options.max_vertices > 0 ? double(options.max_vertices)
                                                     : double(affording_pixels) / kPixelsPerVertex;
    return {SecondsForVertices(vertices) / pace.speed, pace.speed};
  }
  const RunLength by_time{options.time_limit_s, pace.speed};
  const RunLength by_iterations{
      double(options.iterations) / kStepsPerSecond,
      std::max(1.0, double(options.RaysPerStep(pace)) / DevicePace().rays_per_step)};
  if (options.time_limit_s <= 0) return by_iterations;
  if (options.iterations == 0) return by_time;
  return by_iterations.seconds < by_time.seconds ? by_iterations : by_time;
}

uint64_t MaxVertices(const OptimizeOptions& options, const RunLength& length,
                     uint64_t affording_pixels, uint64_t max_tets) {
  uint64_t vertices = options.max_vertices;
  if (vertices == 0 && options.budget == BudgetChoice::kAuto) {
    vertices = AffordableVertices(length.seconds_of_two_cores(), affording_pixels);
  }
  if (max_tets == kNoBudget) return vertices;
  const uint64_t in_budget = uint64_t(double(max_tets) / kTetsPerVertex);
  return vertices == 0 ? in_budget : std::min(vertices, in_budget);
}

std::vector<PlannedRound> PlanRounds(const OptimizeOptions& options, const RunLength& length,
                                     uint64_t start_vertices, uint64_t max_vertices,
                                     uint64_t affording_pixels) {
  // In a run without limits, a given number of rounds is done while it is young.
  const bool is_brief = !options.HasLimit() && options.schedule.rounds;
  const double seconds = is_brief ? kGrowthSeconds : length.seconds;
  const uint64_t growth_vertices =
      AffordableVertices(std::min(seconds, kGrowthSeconds) * length.speed, affording_pixels);
  return PlanGrowth(
      options.schedule, start_vertices,
      seconds > kGrowthSeconds ? std::min(growth_vertices, max_vertices) : max_vertices,
      max_vertices, std::max(1.0, seconds / kGrowthSeconds));
}

}  // namespace tetrec
