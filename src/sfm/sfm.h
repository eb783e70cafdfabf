// Structure from motion: a folder of photos becomes a scene folder, by way of COLMAP.
#pragma once

#include "core/stage.h"
#include "sfm/options.h"

namespace tetrec {

// Reads the stage's input PHOTOS and writes images/*.png, scene.json and points.ply into its
// folder.
void RunSfm(const SfmOptions& options, Stage& stage);

}  // namespace tetrec
