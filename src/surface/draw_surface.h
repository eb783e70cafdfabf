// Pictures of a surface.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/image.h"
#include "mesh/triangle_mesh.h"

#include <vector>

namespace tetrec {

// The surface as a camera sees it: unlit, in the colours of its texture or of its vertices.
struct SurfacePicture {
  Image image;                // RGB; black where there is no surface
  std::vector<bool> covered;  // (height x width) pixels that the surface fills
};
// Writes a colour [display sRGB, 0 to 1] as 8-bit channels.
void SetColor(Image& image, int x, int y, const glm::vec3& color);

// Rays along each side of a pixel: where a surface is fitted to photos, and where its pictures are
// judged. A surface has hard edges, which few rays leave jagged.
inline constexpr int kRaysPerSide = 2, kJudgingRaysPerSide = 4;
// The camera whose pixels are the rays of `camera`.
Camera WithRaysAsPixels(const Camera& camera, int rays_per_side = kRaysPerSide);

// `texture` is empty for the colours of vertices, and grey is drawn without either.
SurfacePicture DrawSurface(const TriangleMesh& mesh_in_world, const Image& texture,
                           const Camera& camera, const Rigid3& cam_from_world,
                           int rays_per_side = kRaysPerSide);

}  // namespace tetrec
