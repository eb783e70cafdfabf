// A surface whose pictures are the photos.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/texture_photos.h"

#include <span>

namespace tetrec {

struct AlignedSurface {
  TriangleMesh mesh;
  double mean_move_px = 0;  // of vertices that photos see, in pixels of these
  // Root mean square difference between the photos and pictures of the surface in the colours of
  // its vertices, in shares of white.
  double error = 0;
};

// Moves vertices, and changes their colours, until pictures of the surface differ least from the
// photos, but for what varies slowly over a photo (LocalMeans): where the surface lies too deep or
// too high, what it shows shifts from photo to photo, and its outlines are elsewhere. Each of
// `rounds` moves all vertices (MovedTowardsPhotos). The first move after which the difference has
// grown is undone and ends the search. Where the photos show too little to decide it, vertices
// follow their neighbours; those at borders stay, so that the edge of a crop holds. The opacity of
// a field is soft, so that its level may lie some pixels before or behind the surface; from more
// than two or three, the moves may not find it. Without rounds, or with fewer than two photos, the
// surface stays as it is. Methods: Lucas and Kanade, An Iterative Image Registration Technique,
// 1981 (moves from gradients of pictures); Delaunoy and Pollefeys, Photometric Bundle Adjustment
// for Dense Multi-View 3D Modeling, 2014 (a mesh and its colours as the unknowns).
AlignedSurface AlignWithPhotos(TriangleMesh mesh_in_world, std::span<const TexturePhoto> photos,
                               int rounds);

}  // namespace tetrec
