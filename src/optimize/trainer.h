// The optimisation of a radiance field against the pictures of a scene.
#pragma once

#include "core/stage.h"
#include "optimize/optimize_options.h"

namespace tetrec {

// Reads the start field of the tetrahedralize stage and the scene before it; writes field.tetf,
// world.json (where the world is in the input's coordinates), exposure.json (if exposures of photos
// were estimated), cameras.json (if corrections of cameras were kept), left_out.json (if photos did
// not fit the others), growth.json (how the mesh grew, and why no further) and metrics.csv
// (iteration, seconds, rays, loss, train_psnr, heldout_psnr, tets, vertices, phase; one row per 2 %
// of the run).
void RunOptimize(const OptimizeOptions& options, Stage& stage);

}  // namespace tetrec
