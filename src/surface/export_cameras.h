// The cameras of a run and its sparse points for other programs that fit fields to photos.
#pragma once

#include "core/stage.h"
#include "geometry/rigid3.h"
#include "surface/export.h"

#include <filesystem>

namespace tetrec {

// Writes, if the formats ask for them, a COLMAP model into the folder sparse/0, whose image names
// are relative to the scene's folder of images, and transforms.json in the conventions of
// nerfstudio, with points.ply beside it. Both contain the training views from the cameras that the
// fit ended with, without the views that it left out, and the held-out views. Throws DataError for
// the files of the scene.
void WriteCameraExports(const ExportOptions& options, const std::filesystem::path& field_folder,
                        const Similarity3& export_from_world, Stage& stage);

}  // namespace tetrec
