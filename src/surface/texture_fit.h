// A texture is fitted to the photos, and the surface with it.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"
#include "surface/texture_layout.h"
#include "surface/texture_photos.h"

#include <span>

namespace tetrec {

struct TextureFit {
  double mean_move_px = 0;  // of the vertices that photos see, in pixels of these
  // Root mean square difference between the photos and pictures of the surface, in shares of white,
  // before the last corrections of the texture; 0 without moves.
  double error = 0;
};

// Draws the surface into all photos and corrects each texel by the mean error of the pixels that
// show it, several times. A baked texture is blurred twice, as its texels are means of pixels,
// which are means of what they cover, and has the coarse colours of vertices where photos only see
// it near outlines; afterwards the surface looks like the photos as far as one colour per point
// can. Few rounds leave noise alone. `mesh_in_world` has texture coordinates, `texture` is RGB.
// Method: Irani and Peleg, Improving Resolution by Image Registration, 1991 (iterative
// back-projection).
//
// In up to `moves` of these rounds, vertices move, too (MovedTowardsPhotos): a texture shows errors
// of position that AlignWithPhotos, in the colours of vertices, is too coarse to find, and those
// that simplification makes. The first move after which the pictures differ more is undone and ends
// the moves. With fewer than two photos nothing moves. Nothing may hide a surface that moves.
TextureFit FitTexture(TriangleMesh& mesh_in_world, const TextureLayout& layout,
                      std::span<const TexturePhoto> photos, int moves, Image& texture);

}  // namespace tetrec
