// How long a run will be, and what it therefore affords.
#pragma once

#include "mesh/tet_mesh.h"
#include "optimize/optimize_options.h"
#include "optimize/schedule.h"
#include "optimize/training_set.h"
#include "render/device_pace.h"

#include <cstdint>
#include <vector>

namespace tetrec {

// How long a run takes, and how long two cores would take for as many rays.
struct RunLength {
  double seconds = 0, seconds_of_two_cores = 0;
};

// The pixels that afford vertices: those of the subject, and as many as the start mesh takes at
// least, so that what it drops may be put where errors are.
uint64_t AffordingPixels(const TrainingSet& set, const TetMesh& start);

// A run without limits may grow to the most vertices that the options, `max_tets` (or kNoBudget)
// and the pixels allow. Runs by iterations, and those without limits, are as long on every device,
// but their steps may have more rays.
RunLength LengthOf(const OptimizeOptions& options, const DevicePace& pace,
                   uint64_t affording_pixels, uint64_t max_tets);

// The most vertices of a run; 0: no limit. `max_tets` (or kNoBudget) is never exceeded.
uint64_t MaxVertices(const OptimizeOptions& options, const RunLength& length,
                     uint64_t affording_pixels, uint64_t max_tets);

// The rounds of refinement from `start_vertices` to `max_vertices` (PlanGrowth).
std::vector<PlannedRound> PlanRounds(const OptimizeOptions& options, const RunLength& length,
                                     uint64_t start_vertices, uint64_t max_vertices,
                                     uint64_t affording_pixels);

}  // namespace tetrec
