// COLMAP's sparse models as files. Format: COLMAP documentation, "Output Format".
#pragma once

#include "colmap/model.h"
#include "geometry/camera.h"

#include <filesystem>

namespace tetrec {

Lens PinholeLens(const Camera& camera);

// Writes cameras.bin, images.bin and points3D.bin into the folder, which is created if it does not
// exist. Unlike text, they may contain names with spaces.
void WriteColmapModel(const std::filesystem::path& folder, const ColmapModel& model);

}  // namespace tetrec
