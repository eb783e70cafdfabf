// Data sets with known cameras into scene folders.
#pragma once

#include "core/stage.h"
#include "scene/scene.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct ImportOptions {
  std::string format = "nerf-synthetic";
  int max_size = 400;                          // [px] bound of the longer side; 0: as stored
  Background background = Background::kWhite;  // behind pictures with alpha; white or black
  void Check() const;                          // throws UsageError naming the option and its value
};

struct ImportedScene {
  Scene scene;
  size_t resized = 0;                       // pictures
  std::vector<std::string> missing_splits;  // files that are not there
};

// Reads the data set, resizes its pictures (in parallel), finds the subject's bounds by carving the
// training masks (without alpha: what all training cameras see), moves the world so that the
// subject's longest side is 2 and its centre 0, and writes the scene folder. Throws DataError.
ImportedScene ImportDataset(const std::filesystem::path& dataset,
                            const std::filesystem::path& folder, const ImportOptions& options);

// The stage: input "DATASET".
void RunImport(const ImportOptions& options, Stage& stage);

// Width and height scaled down so that the longer side is at most `max_size` (0: no bound).
glm::ivec2 FitToMaxSize(int width, int height, int max_size);

}  // namespace tetrec
