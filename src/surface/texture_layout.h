// Where a surface's charts lie in its texture.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/texture_charts.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Texels around each chart that belong to no other one.
inline constexpr int kTexturePadding = 2;

struct TextureLayout {
  int size = 0;           // of the square texture [texels]
  double texel_size = 0;  // [units of the mesh], the same in all charts
  // (M) The corners of each triangle [texels from the upper left corner, y down].
  std::vector<std::array<glm::dvec2, 3>> corners;
};

// Puts the charts into the smallest square of a power of two, from 64 to `max_size`, into which
// they fit with texels of `texel_size`, or else into the largest; texels then become as small as
// still fit.
// Method: skyline, bottom left (Jylänki, A Thousand Ways to Pack the Bin, 2010).
TextureLayout LayOutTexture(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                            double texel_size, int max_size);
// With texels as small as fit into a square of `size`. Throws UsageError if no size of texels fits,
// because there are more charts than room for their padding.
TextureLayout LayOutTextureOfSize(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                                  int size);

// Returns the texture coordinates of the corners of all triangles, as TriangleMesh stores them.
std::vector<std::array<glm::vec2, 3>> CornerCoordinates(const TextureLayout& layout);

}  // namespace tetrec
