// The colours of a texture's texels, from the photos that see them.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"
#include "surface/texture_layout.h"
#include "surface/texture_photos.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// The median over the seen surface of the length that a pixel of the best photo covers [world
// units]: photos of up to half of the surface have finer pixels. 0 if no photo sees anything.
double MedianFootprint(const TriangleMesh& mesh_in_world, std::span<const TexturePhoto> photos);

struct BakedTexture {
  Image image;            // RGB, display sRGB
  double seen_share = 0;  // of the texels on the surface, by how far photos decide their colour
  uint64_t limited_triangles = 0;  // of which PhotosOfTriangles leaves photos out
};

// Each texel is the mean of the three photos that see it best: from the front, from near and away
// from outlines. The weights are those beyond the fourth photo's, so that colours change
// continuously where one photo takes the place of another; they depend on the point of the surface,
// and on its triangle's photos (PhotosOfTriangles), so that colours agree across the borders of
// charts. What no photo sees has the vertices' colours. Texels outside all charts are black.
// `mesh_in_world` has vertex colours.
BakedTexture BakeTexture(const TriangleMesh& mesh_in_world, const TextureLayout& layout,
                         std::span<const TexturePhoto> photos);

}  // namespace tetrec
