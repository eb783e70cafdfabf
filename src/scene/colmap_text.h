// COLMAP's sparse models as text: cameras.txt, images.txt and points3D.txt. Format: COLMAP
// documentation, "Output Format".
#pragma once

#include "scene/colmap_model.h"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace tetrec {

// As their namesakes for binary files; DataError names the line. Lines that start with # and, but
// for the second line of an image, empty lines are passed over. A picture's name is all that
// follows the camera's id, spaces too. A camera of an unknown model is read as kColmapUnknownLens:
// only CheckColmapModel knows whether a picture has it.
std::map<uint32_t, ColmapCamera> ParseColmapCamerasText(std::string_view text,
                                                        const std::string& name);
std::map<uint32_t, ColmapImage> ParseColmapImagesText(std::string_view text,
                                                      const std::string& name);
std::map<uint64_t, ColmapPoint> ParseColmapPointsText(std::string_view text,
                                                      const std::string& name);

}  // namespace tetrec
