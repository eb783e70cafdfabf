// Distances on a surface, along the edges of its triangles.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// The distance of each vertex from the nearest source along edges [units of the positions];
// infinite where it is larger than `farthest`. `is_source`: a flag per vertex. (Dijkstra 1959)
std::vector<float> EdgeDistances(std::span<const glm::vec3> positions,
                                 std::span<const glm::uvec3> triangles,
                                 std::span<const uint8_t> is_source, float farthest);

}  // namespace tetrec
