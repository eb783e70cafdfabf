// Images of a triangle mesh by a small z-buffer rasteriser on the CPU.
#pragma once

#include "geometry/bounds3.h"
#include "image/image.h"
#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

struct PreviewOptions {
  int size_px = 320;  // images are square
  int views = 6;      // steps of one turn around the up axis
  glm::dvec3 up{0, 0, 1};
  double elevation_deg = 20;
  Bounds3 bounds;          // triangles whose centre is outside are left out
  bool use_colors = true;  // false, or a mesh without colours: grey clay
};

// One RGB picture per step of the turntable, lit from the camera, with back sides in a dull blue so
// that holes are visible. Equal input gives equal pixels. A mesh without triangles inside the
// bounds gives blank images.
std::vector<Image> RenderTurntable(const TriangleMesh& mesh, const PreviewOptions& options);

}  // namespace tetrec
