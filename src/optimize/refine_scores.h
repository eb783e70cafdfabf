// What the images ask of the mesh: the scores that a refinement takes.
#pragma once

#include "optimize/batches.h"
#include "optimize/optimize_options.h"
#include "optimize/training_set.h"
#include "refine/refine.h"
#include "render/training_renderer.h"

#include <cstdint>

namespace tetrec {

// Scores of the kind of the options, from as many rays as the field's tets need to be judged.
// Gradients that wait in the renderer for an update are lost.
RefineScores LookAtScores(TrainingRenderer& renderer, const TrainingSet& set, BatchDrawer& batches,
                          const OptimizeOptions& options, uint64_t iteration);

}  // namespace tetrec
