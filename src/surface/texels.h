// Which triangle each texel of a texture shows.
#pragma once

#include "mesh/seen_triangles.h"
#include "surface/texture_layout.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace tetrec {

struct Texels {
  int size = 0;
  // (size x size) the triangle that contains the texel's centre, or the nearest one of the chart
  // within the padding, from which filters take colours, too; kNoTriangle elsewhere.
  std::vector<uint32_t> triangle;
};

Texels FindTexels(const TextureLayout& layout);

// The weights of the corners at the point of the triangle that is nearest to `p`.
glm::dvec3 NearestWeights(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& p);

}  // namespace tetrec
