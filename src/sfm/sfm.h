// Structure from motion: a folder of photos, or a video, becomes a scene folder, by way of COLMAP.
#pragma once

#include "core/stage.h"
#include "sfm/options.h"

namespace tetrec {

// Reads the stage's input PHOTOS, a folder or the file of a video, and writes images/*.png,
// scene.json and points.ply into its folder.
void RunSfm(const SfmOptions& options, Stage& stage);

}  // namespace tetrec
