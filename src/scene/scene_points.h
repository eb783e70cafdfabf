// Sparse points as PLY files: the scene folder's own, and those of other programs.
#pragma once

#include "scene/scene.h"

#include <filesystem>
#include <vector>

namespace tetrec {

// points.ply of a scene folder: x y z, red green blue (0 to 255), reprojection_error, track_length.
// Throws DataError naming the file and the property, also where a value is none that it can have.
std::vector<ScenePoint> ReadScenePoints(const std::filesystem::path& path);
void WriteScenePoints(const std::filesystem::path& path, const std::vector<ScenePoint>& points);

// Of any program: x y z and red green blue (0 to 255) alone; the error is 0 and the track length 0,
// which is unknown. Throws as ReadScenePoints.
std::vector<ScenePoint> ReadColoredPoints(const std::filesystem::path& path);

}  // namespace tetrec
