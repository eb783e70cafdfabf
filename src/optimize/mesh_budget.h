// The bound on the size of the mesh that the options give, in tets or as memory.
#pragma once

#include "mesh/tet_mesh.h"
#include "optimize/optimize_options.h"
#include "optimize/training_set.h"

#include <cstdint>

namespace tetrec {

// A Delaunay mesh of lego, fox and the demo has 6.4 to 6.6 tets per vertex.
inline constexpr double kTetsPerVertex = 6.5;

// A bound on the peak of resident memory of a run [bytes]: 145 MB + 14 B per training pixel + 330 B
// per tet, 380 B where harmonics reach degree 3. It is above the peaks of 15 runs with degree 2 and
// 13 with degree 3 (0.27 to 1.01 M tets, 1.2 to 6 M pixels) by 4 to 76 MB, and farther above those
// without harmonics.
double PredictedPeakBytes(uint32_t harmonics_degree, double tets, uint64_t pixels);

// The number of tets that a run never exceeds, kNoBudget without a budget. Throws UsageError if
// the start mesh has more.
inline constexpr uint64_t kNoBudget = ~uint64_t{0};
uint64_t TetBudget(const OptimizeOptions& options, const TrainingSet& set, uint64_t start_tets);

}  // namespace tetrec
