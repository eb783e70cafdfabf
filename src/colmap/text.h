// COLMAP's sparse models as text: cameras.txt, images.txt and points3D.txt. Format: COLMAP
// documentation, "Output Format".
#pragma once

#include "colmap/model.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace tetrec {

// Counterparts of the functions for binary files; DataError names the line. Lines that start with #
// are skipped, and so are empty lines, except for the second line of an image. An image's name is
// everything after the camera's id, including spaces. A camera of an unknown model is read as
// LensModel::kUnknown: only CheckColmapModel knows whether an image refers to it.
std::map<uint32_t, Lens> ParseColmapCamerasText(std::string_view text, const std::string& name);
std::map<uint32_t, ColmapImage> ParseColmapImagesText(std::string_view text,
                                                      const std::string& name);
std::map<uint64_t, ColmapPoint> ParseColmapPointsText(std::string_view text,
                                                      const std::string& name);

}  // namespace tetrec
