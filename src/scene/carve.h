// Space carving from alpha masks: whatever some view sees through is outside the subject.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/camera.h"
#include "geometry/occupancy_grid.h"
#include "geometry/rigid3.h"
#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

struct AlphaMask {
  Camera camera;
  Rigid3 cam_from_world;
  std::vector<uint8_t> alpha;  // camera.height x camera.width, row by row
};

// Reads the alpha of all training views of a scene folder, in parallel. Throws DataError if the
// scene has no alpha or an image differs in size from its camera.
std::vector<AlphaMask> ReadTrainingMasks(const std::filesystem::path& folder, const Scene& scene);

// A cell is outside if some view sees the square around its projected bounding sphere entirely
// within the image and entirely transparent (alpha 0). This is conservative, so that the thinnest
// parts survive. A view that sees only part of the square does not count for the cell. Cells that
// fewer than `min_views` views see whole are outside too; 0 keeps cells that no view sees whole.
OccupancyGrid CarveMasks(std::span<const AlphaMask> masks, const Bounds3& bounds,
                         const glm::ivec3& size, int min_views = 1);

// The cube inscribed in the largest ball, around the point that all cameras look at, that every
// camera sees whole. Does not use alpha. Returns nothing if the cameras' axes do not meet in front
// of them because the cameras look outwards or all in the same direction.
std::optional<Bounds3> BoxSeenByAll(std::span<const AlphaMask> masks);

// The bounding box of the camera centres, grown on every side by its longest side so that it
// contains whatever is as near to the cameras as they are to each other. Does not use alpha. Throws
// DataError if all cameras are in one place.
Bounds3 BoxAroundCameras(std::span<const AlphaMask> masks);

// The bounding box of the subject, from its masks alone. Carves a coarse grid over everything that
// any view shows around the point that the cameras look at, shrinks the box to what is inside,
// repeats this twice, and grows the result on all sides by `margin` of its longest side. Only cells
// that at least half of the views see count; otherwise distant shells that few views see would
// inflate the box. If some opaque pixel then looks past the box (at a part that few images show), a
// quarter of the views suffices, and finally a single view. Throws DataError if nothing is left or
// the cameras' axes do not meet.
Bounds3 FindSubjectBounds(std::span<const AlphaMask> masks, double margin = 0.01);

}  // namespace tetrec
