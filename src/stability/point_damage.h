// Damages to the sparse points of a scene.
#pragma once

#include "scene/scene.h"

#include <cstddef>
#include <cstdint>

namespace tetrec {

// Moves this share of the points to random places in the box of all points.
void MisplacePoints(Scene& scene, double share, uint64_t seed);
// Moves all points to the horizontal plane through the subject's centre.
void FlattenPoints(Scene& scene);
// Moves all points to the subject's centre.
void CollapsePoints(Scene& scene);
// Keeps the first `count` points.
void KeepPoints(Scene& scene, size_t count);

}  // namespace tetrec
