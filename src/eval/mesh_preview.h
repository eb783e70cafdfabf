// Pictures of a triangle mesh by a small z-buffer rasteriser on the CPU.
#pragma once

#include "geometry/bounds3.h"
#include "mesh/triangle_mesh.h"
#include "scene/image.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

struct PreviewOptions {
  int size_px = 320;  // pictures are square
  int views = 6;      // steps of one turn around the up axis
  glm::dvec3 up{0, 0, 1};
  double elevation_deg = 20;
  Bounds3 bounds;          // what to show; triangles whose centre lies outside are left out
  bool use_colors = true;  // false, or a mesh without colours: grey clay
};

// One RGB picture per step of the turntable, lit from the camera, back sides in a dull blue so that
// holes show. Equal input gives equal pixels. A mesh without triangles inside the bounds gives
// blank pictures.
std::vector<Image> RenderTurntable(const TriangleMesh& mesh, const PreviewOptions& options);

}  // namespace tetrec
