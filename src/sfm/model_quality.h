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
// built on. Errors are judged in pixels of a photo of 1,600 px, and 2 px are too large in any
// photo.
ModelQuality JudgeModel(const ColmapModel& model, const std::vector<std::string>& photo_names);

// The names that the model does not have, in their order.
std::vector<std::string> UnregisteredPhotos(const ColmapModel& model,
                                            const std::vector<std::string>& photo_names);

}  // namespace tetrec
