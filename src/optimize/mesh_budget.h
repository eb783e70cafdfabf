// The bound on the size of the mesh that the options give, in tets or as memory.
#pragma once

#include "mesh/tet_mesh.h"
#include "optimize/optimize_options.h"

#include <cstdint>

namespace tetrec {

// A Delaunay mesh of lego, fox and the demo has 6.4 to 6.6 tets per vertex.
inline constexpr double kTetsPerVertex = 6.5;

// The peak of resident memory of a run [bytes]: 186 MB + 23 B per training pixel + 213 B per tet,
// fitted to 16 runs on lego, fox and the demo (0.47 to 1.17 M tets, 2.7 to 16 M pixels; error 20 MB
// root mean square, at most 32 MB too low), and 34 MB more, so that it is a bound.
double PredictedPeakBytes(double tets, uint64_t pixels);

// The number of tets that a run never exceeds, kNoBudget without a budget. Throws UsageError if
// the start mesh has more.
inline constexpr uint64_t kNoBudget = ~uint64_t{0};
uint64_t TetBudget(const OptimizeOptions& options, uint64_t pixels, uint64_t start_tets);

}  // namespace tetrec
