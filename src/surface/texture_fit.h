// A texture is fitted to the photos.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"
#include "surface/texture_layout.h"
#include "surface/texture_photos.h"

#include <span>

namespace tetrec {

// Draws the surface into all photos and corrects each texel by the mean error of the pixels that
// show it, several times. A baked texture is blurred twice, as its texels are means of pixels,
// which are means of what they cover, and has the coarse colours of vertices where photos only see
// it near outlines; afterwards the surface looks like the photos as far as one colour per point
// can. Few rounds leave noise alone. `mesh_in_world` has texture coordinates, `texture` is RGB.
// Method: Irani and Peleg, Improving Resolution by Image Registration, 1991 (iterative
// back-projection). Needs 32 bytes for each pixel of a photo and thread.
void FitTexture(const TriangleMesh& mesh_in_world, const TextureLayout& layout,
                std::span<const TexturePhoto> photos, Image& texture);

}  // namespace tetrec
