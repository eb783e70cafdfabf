// The function whose level set is the surface.
#pragma once

#include "mesh/tet_mesh.h"

#include <span>
#include <vector>

namespace tetrec {

// How full space is at each vertex, from 0 (free) to 1; kSurfaceOccupancy at the isovalue. Bounded,
// so that no single vertex outweighs its neighbours: o = density / (density + isovalue). If values
// of density are negative somewhere, they place the surface by how far below 0 they are, as large
// values do by how far above: then o = (1 + x / (1 + |x|)) / 2, x = (density / isovalue - 1) / 5.
// Then `rounds` times each vertex becomes the mean of itself and of its neighbours' mean (a
// neighbour counts by the tets that it shares): what one vertex alone says is noise, which would
// crumple the surface and riddle the inside, that no photo sees, with cavities.
inline constexpr float kSurfaceOccupancy = 0.5f;
std::vector<float> SmoothedOccupancy(const TetMesh& mesh, std::span<const float> density,
                                     double isovalue, int rounds);

}  // namespace tetrec
