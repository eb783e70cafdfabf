// COLMAP models with their pictures as data sets: the model in the folder itself, in sparse/0,
// sparse, colmap/sparse/0 or colmap/sparse, the pictures in images/ beside or above it. Masks,
// where there are any, in masks/ beside images/, named as COLMAP does (PICTURE.EXT.png) or
// PICTURE.png; what is black in them is not to be seen.
#pragma once

#include "scene/dataset.h"

#include <filesystem>
#include <optional>

namespace tetrec {

// The folder of the model; none where there is none.
std::optional<std::filesystem::path> FindColmapModel(const std::filesystem::path& folder);

// `images` names the folder of the pictures, e.g. images_4 of the same pictures a quarter as large.
// Throws DataError: no model, a model as ReadColmapModel refuses it or without pictures, pictures
// that are missing (see HandleMissingPictures).
Dataset ReadColmapDataset(const std::filesystem::path& folder, const std::string& images = "images",
                          MissingPictures missing = MissingPictures::kRefuse);

}  // namespace tetrec
