// Sparse points for scenes with known cameras: COLMAP's features, Tetrec's matches, and COLMAP's
// triangulation with fixed cameras.
#pragma once

#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

// Folders and files of the work. They may contain the work of an earlier run, even of one that was
// killed.
struct ColmapPlace {
  std::filesystem::path log;  // receives COLMAP's output
  std::filesystem::path
      cache;  // features and matches, under a name that depends on all their inputs
  std::filesystem::path scratch;  // not needed afterwards
};

// Per view, the alpha of its image, row by row; empty if the image is opaque.
using ViewAlphas = std::vector<std::vector<uint8_t>>;

// True if a training view of `scene` sees through the point: alpha is 0 at all four pixels around
// it.
bool IsSeenThrough(const Scene& scene, const ViewAlphas& alphas, const glm::dvec3& point);

struct Triangulation {
  std::vector<ScenePoint> points;  // in the scene's coordinates, in COLMAP's order
  size_t found = 0;                // by COLMAP, including the dropped ones below
  size_t weak = 0;                 // dropped: seen by fewer than 3 views, or more than 2 px error
  size_t transparent = 0;          // dropped: a training view sees through them
};

// Points from the training views of `scene`, whose images are in `folder`; images with alpha are
// composited over the background first. `alphas`: one per view. The same images and cameras give
// the same bytes. Throws DataError if no point is found, EnvironmentError without COLMAP.
Triangulation TriangulatePoints(const std::filesystem::path& folder, const Scene& scene,
                                const ViewAlphas& alphas, const ColmapPlace& place);

}  // namespace tetrec
