// COLMAP models with their pictures as data sets: the model in the folder itself, in sparse/0,
// sparse, colmap/sparse/0 or colmap/sparse, the pictures in images/ beside or above it.
#pragma once

#include "scene/dataset.h"

#include <filesystem>
#include <optional>

namespace tetrec {

// The folder of the model; none where there is none.
std::optional<std::filesystem::path> FindColmapModel(const std::filesystem::path& folder);

// Throws DataError: no model, a model as ReadColmapModel refuses it, a picture that is missing or
// leaves the folder.
Dataset ReadColmapDataset(const std::filesystem::path& folder);

}  // namespace tetrec
