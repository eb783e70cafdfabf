// Aligns a reconstruction, whose frame is arbitrary up to a similarity, with the true cameras.
#pragma once

#include "geometry/rigid3.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct TrueCamera {
  std::string file;       // image, e.g. "photos/0001.jpg"
  Rigid3 cam_from_truth;  // COLMAP axes
};

// Reads {"frames": [{"file", "cam_from_world": 3 x 4, row by row, [R | t]}]}; intrinsics are
// ignored. Throws DataError naming frame and field: wrong shape, not finite, not a rotation.
std::vector<TrueCamera> ReadTrueCameras(const std::filesystem::path& path);

// The similarity that minimises the sum of |to - (s R from + t)|^2 (Umeyama 1991). Throws DataError
// for fewer than 3 points, different counts, or points on one line, which leave a rotation free.
Similarity3 FitSimilarity(std::span<const glm::dvec3> from, std::span<const glm::dvec3> to);

struct Alignment {
  Similarity3 truth_from_input;
  size_t matched = 0;                  // views that have a true camera
  std::vector<std::string> unmatched;  // names of the scene's views that have none
  // Distances of the aligned camera centres from the true ones [units of the truth].
  double center_rms = 0, center_max = 0;
  double center_spread = 0;  // rms distance of the true centres from their mean
  double rotation_mean_deg = 0, rotation_max_deg = 0;
};

// Fits the camera centres of all views that have a true camera with the same image name. Two names
// match if one path ends with the other, image extensions aside ("0001" and "photos/0001.jpg").
// Throws DataError if a view matches two cameras or fewer than 3 views match.
Alignment AlignByCameras(const Scene& scene, std::span<const TrueCamera> cameras);

}  // namespace tetrec
