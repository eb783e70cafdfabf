// From photos to the model that COLMAP finds of them.
#pragma once

#include "colmap/model.h"
#include "core/stage.h"
#include "sfm/options.h"
#include "sfm/photos.h"

#include <vector>

namespace tetrec {

// Cameras, poses and points by the lens that was asked for. If that is chosen automatically,
// simpler ones are tried while the photos do not determine the one that is found: it cannot be
// undone, its pixels are not square and a lens of square ones fits as well, or it registers too few
// photos and a simpler one registers more. Images have the photos' own names. Features, matches and
// models stay in the stage's cache. Throws DataError if there is no model.
ColmapModel MapPhotos(const SfmOptions& options, const std::vector<Photo>& photos, Stage& stage);

}  // namespace tetrec
