// Sparse points for scenes whose cameras are known: COLMAP's features, Tetrec's matches, COLMAP's
// triangulation with the cameras held fixed.
#pragma once

#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

// Where the work is done. All of it may stay from an earlier run, also from one that was killed.
struct ColmapPlace {
  std::filesystem::path log;      // receives COLMAP's output
  std::filesystem::path cache;    // features and matches, under a name of all that decides them
  std::filesystem::path scratch;  // of no use afterwards
};

// What is seen of the subject in one view: alpha of its picture, row by row; empty: all of it.
using ViewAlphas = std::vector<std::vector<uint8_t>>;

// Whether some training view of `scene` sees through the place: alpha 0 at all four pixels around
// it.
bool IsSeenThrough(const Scene& scene, const ViewAlphas& alphas, const glm::dvec3& point);

struct Triangulation {
  std::vector<ScenePoint> points;  // in the scene's coordinates, in COLMAP's order
  size_t found = 0;                // by COLMAP; the rest of these numbers are dropped ones
  size_t weak = 0;                 // seen by fewer than 3 views, or with more than 2 px error
  size_t transparent = 0;          // where some training view sees through
};

// Points from the training views of `scene`, whose pictures lie in `folder`; pictures with alpha
// are composited over the background first. `alphas`: one a view. The same pictures and cameras
// give the same bytes. Throws DataError where no point is found, EnvironmentError without COLMAP.
Triangulation TriangulatePoints(const std::filesystem::path& folder, const Scene& scene,
                                const ViewAlphas& alphas, const ColmapPlace& place);

}  // namespace tetrec
