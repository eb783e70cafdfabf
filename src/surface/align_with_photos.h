// A surface that lies where the photos agree on it.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/texture_photos.h"

#include <cstddef>
#include <span>

namespace tetrec {

struct AlignedSurface {
  TriangleMesh mesh;
  size_t agreed = 0;        // vertices for which photos agreed on a place
  double mean_move_px = 0;  // of all vertices, in pixels of the photos that see them
};

// Moves vertices along their normals to where the photos that see them correlate best
// (PhotoPatches). Where they show too little to decide it, vertices follow their neighbours; those
// at borders stay, so that a crop holds. The opacity of a field is soft, so that its level may lie
// some pixels before or behind the surface. Moves are shortened where the surface would cross
// itself (StepBackFromCrossings). Each of `rounds` searches half as far as the one before it; 0:
// none. Fills in depth and trust of the photos. Methods: Furukawa and Ponce, Accurate, Dense, and
// Robust Multiview Stereopsis, 2010 (patches that the photos agree on); Vu et al., High Accuracy
// and Visibility-Consistent Dense Multiview Stereo, 2012 (a mesh as the unknown).
AlignedSurface AlignWithPhotos(TriangleMesh mesh_in_world, std::span<TexturePhoto> photos,
                               int rounds);

}  // namespace tetrec
