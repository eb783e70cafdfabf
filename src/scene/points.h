// Sparse points as PLY files, those of scene folders and those of other programs.
#pragma once

#include "scene/scene.h"

#include <filesystem>
#include <vector>

namespace tetrec {

// No coordinate of a point is larger.
inline constexpr double kFarthestPoint = 1e9;

// points.ply of a scene folder: x y z, red green blue (0 to 255), reprojection_error, track_length.
// Throws DataError naming the file and the property, also if a value is out of range.
std::vector<ScenePoint> ReadScenePoints(const std::filesystem::path& path);
void WriteScenePoints(const std::filesystem::path& path, const std::vector<ScenePoint>& points);

// Points of any program: reads only x y z and red green blue (0 to 255, or 0 to 1 as floating-point
// numbers). The reprojection error is 0; the track length is 0, which means unknown. Throws like
// ReadScenePoints.
std::vector<ScenePoint> ReadColoredPoints(const std::filesystem::path& path);

}  // namespace tetrec
