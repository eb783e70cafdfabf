// Space carving from alpha masks: what every view sees through is outside.
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

// Alpha of the training views of a scene folder (decoded in parallel). Throws DataError where the
// scene has none or a picture differs in size from its camera.
std::vector<AlphaMask> ReadTrainingMasks(const std::filesystem::path& folder, const Scene& scene);

// A cell is outside where some view sees the square around its projected bounding sphere wholly
// inside the picture and wholly transparent (alpha 0): conservative, so that the thinnest parts
// survive. Views that see only part of that square say nothing about the cell. Cells that fewer
// than `min_views` views see whole are outside too; 0 keeps cells of which nothing is known.
OccupancyGrid CarveMasks(std::span<const AlphaMask> masks, const Bounds3& bounds,
                         const glm::ivec3& size, int min_views = 1);

// Cube in the largest ball around the point that all cameras look at that all of them see whole;
// uses no alpha. None where the cameras' axes do not meet in front of them: they look outwards, or
// all the same way.
std::optional<Bounds3> BoxSeenByAll(std::span<const AlphaMask> masks);

// Box of the cameras' places, grown on every side by its longest side, so that it holds what is as
// near to them as they are to each other; uses no alpha. Throws DataError where all cameras are at
// one place.
Bounds3 BoxAroundCameras(std::span<const AlphaMask> masks);

// Box of the subject, from its masks alone: carves a coarse grid over all that any view shows
// around the point that the cameras look at, shrinks the box to what is inside, twice, and grows
// the last one by `margin` of its longest side all around. Only cells that at least half of the
// views see count, since shells far off, seen by few, would else blow it up; where opaque pixels
// then see past the box (parts that few pictures show), a quarter of the views is enough, and at
// last one view. Throws DataError where nothing is left or the cameras' axes do not meet.
Bounds3 FindSubjectBounds(std::span<const AlphaMask> masks, double margin = 0.01);

}  // namespace tetrec
