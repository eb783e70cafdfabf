// A look at the errors of a field: which tets the images blame.
#pragma once

#include "optimize/batches.h"
#include "optimize/optimize_options.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <vector>

namespace tetrec {

// Scores per tet, from blocks that are drawn in random order, none twice, as many as `tets` tets
// need to be judged.
std::vector<float> LookAtErrors(TrainingRenderer& renderer, const TrainingSet& set,
                                const BatchDrawer& batches, const OptimizeOptions& options,
                                uint64_t tets, uint64_t iteration);

}  // namespace tetrec
