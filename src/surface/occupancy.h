// The function whose level set is the surface.
#pragma once

#include "mesh/tet_mesh.h"

#include <span>
#include <vector>

namespace tetrec {

// How full space is at each vertex: o = density / (density + isovalue), from 0 (free) to 1, which
// is kSurfaceOccupancy at the isovalue. Bounded, so that no single vertex outweighs its neighbours.
// Then `rounds` times each vertex becomes the mean of itself and of its neighbours' mean (a
// neighbour counts by the tets that it shares): what one vertex alone says is noise, which would
// crumple the surface and riddle the inside, that no photo sees, with cavities.
inline constexpr float kSurfaceOccupancy = 0.5f;
std::vector<float> SmoothedOccupancy(const TetMesh& mesh, std::span<const float> density,
                                     double isovalue, int rounds);

}  // namespace tetrec
