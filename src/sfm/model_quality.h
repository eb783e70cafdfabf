// The quality that COLMAP's model must have.
#pragma once

#include "colmap/model.h"

#include <string>
#include <vector>

namespace tetrec {

struct ModelQuality {
  size_t registered = 0, photos = 0, points = 0;
  double mean_error_px = 0, mean_track_length = 0;
};

// False if too few of the photos are registered for a model that can be built on.
bool HasEnoughPhotos(const ColmapModel& model, size_t photos);

// Throws DataError, which names what is wrong and the unregistered photos, if the model cannot be
// built on. The mean error may be 1.5 px in photos of up to 1,600 px, and in proportion to their
// size up to 2.5 px in larger ones.
ModelQuality JudgeModel(const ColmapModel& model, const std::vector<std::string>& photo_names);

// The names that the model does not have, in their order.
std::vector<std::string> UnregisteredPhotos(const ColmapModel& model,
                                            const std::vector<std::string>& photo_names);

}  // namespace tetrec
