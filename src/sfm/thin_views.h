// Fewer training views, to measure how few photos suffice.
#pragma once

#include "colmap/model.h"
#include "scene/scene.h"

namespace tetrec {

// Keeps the held-out views and, of the training views, those at places 1, 1 + every, 1 + 2 every,
// ... in the scene's order of views (for an `every` of 4 and every 8th view held out, the two never
// meet). Of the points, which must be the model's in the model's order, keeps those that at least
// two of the kept training views see, and counts only these in their track lengths; their positions
// stay those that all photos gave. Returns the number of views left out. Throws DataError if fewer
// than two training views are left.
size_t ThinTrainingViews(const ColmapModel& model, int every, Scene& scene);

}  // namespace tetrec
