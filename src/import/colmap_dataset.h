// Data sets of a COLMAP model and its images. The model is in the folder itself or in sparse/0,
// sparse, colmap/sparse/0 or colmap/sparse; the images are in images/ beside the model or above it.
// Masks, if any, are in masks/ beside images/, named as COLMAP does (IMAGE.EXT.png) or IMAGE.png;
// their black pixels hide the image.
#pragma once

#include "import/dataset.h"

#include <filesystem>
#include <optional>

namespace tetrec {

// The folder of the model, if there is one.
std::optional<std::filesystem::path> FindColmapModel(const std::filesystem::path& folder);

// True if none of the model's three parts is missing, nor its folder images/.
bool HasWholeColmapModel(const std::filesystem::path& folder);

// Throws UsageError if the folder of images is not inside the data set, DataError if there is no
// model, if ReadColmapModel refuses it (which drops dangling references), if it has no images, or
// if images are missing (see HandleMissingPictures).
Dataset ReadColmapDataset(const std::filesystem::path& folder, const DatasetReading& reading = {});

}  // namespace tetrec
