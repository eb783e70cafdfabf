// How the pictures of a surface differ from the photos, and what its vertices could do about it.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/draw_surface.h"
#include "surface/surface_colors.h"
#include "surface/texture_photos.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

// Sums over the rays that meet a vertex's triangles, each weighted by the vertex's share of the
// point that it meets. Moves are in footprints: lengths that one pixel covers there.
struct VertexDifferences {
  // Half the rate at which the squared local error falls with a move, and half its second
  // derivative (Gauss-Newton). Products of different vertices of a triangle are added to the
  // diagonal, so that moving all vertices at once does not overshoot.
  glm::vec3 pull{0.0f};
  glm::mat3 curvature{0.0f};
  // Errors of colour [display sRGB] and their weight, over pixels that show nothing but the
  // surface.
  glm::vec3 color_error{0.0f};
  float color_weight = 0;
  float footprint = 0, seen = 0;  // the footprints' sum [world units], and the shares'

  VertexDifferences& operator+=(const VertexDifferences& other);
};

struct PhotoDifferences {
  std::vector<VertexDifferences> vertices;
  // Per channel, over the pixels that show a part of the surface, or of the subject where alpha is
  // opacity. The second is that of local errors, which moves can reduce: errors less their
  // LocalMeans.
  double mean_squared_error = 0, mean_squared_local_error = 0;
};

// Draws the surface in these colours with 4 rays per pixel. Where alpha is opacity, colours are
// multiplied by it, and the opacity itself is a channel, so that outlines pull, whatever the
// colours are; in other photos only pixels count that the surface fills. Pixels that show a border
// of the surface or its back, and those next to them, do not count: the photo may show what was cut
// off there. `border` are the mesh's BorderVertices. A pixel moves with the nearest surface that it
// shows, not with what is behind that. `pictures` is empty, or becomes what was drawn into each
// photo. Needs 32 bytes for each pixel of a photo and thread.
PhotoDifferences CompareWithPhotos(const TriangleMesh& mesh_in_world,
                                   const std::vector<bool>& border, const SurfaceColors& color_at,
                                   std::span<const TexturePhoto> photos,
                                   std::span<SurfacePicture> pictures = {});

}  // namespace tetrec
