// A look at the errors of a field: which tets the images blame.
#pragma once

#include "mesh/mesh_edges.h"
#include "optimize/batches.h"
#include "optimize/optimize_options.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <vector>

namespace tetrec {

// The squared errors and the light of the tets, from blocks that are drawn in random order, none
// twice, as many as the field's tets need to be judged: a ray per tet or more, because fewer would
// miss tets that are seen.
TetScores LookAtTets(TrainingRenderer& renderer, const TrainingSet& set, const BatchDrawer& batches,
                     const OptimizeOptions& options, uint64_t iteration);

// The number of tets in which no ray loses 1 % of its light.
uint64_t CountEmpty(const std::vector<float>& light_of_tets);

// From the same blocks, the variance over the views of the error that each view blames on a tet:
// large where the views disagree, so that no value of the tet's vertices suits them all.
std::vector<float> LookAtVariances(TrainingRenderer& renderer, const TrainingSet& set,
                                   const BatchDrawer& batches, const OptimizeOptions& options,
                                   uint64_t iteration);

// From the same blocks, what they say of a vertex in the middle of each edge of the field's mesh.
std::vector<EdgeSums> LookAtEdges(TrainingRenderer& renderer, const TrainingSet& set,
                                  const BatchDrawer& batches, const OptimizeOptions& options,
                                  uint64_t iteration, const MeshEdges& edges);

}  // namespace tetrec
