// A z-buffer, and the mean over the rays of a pixel.
#include "surface/draw_surface.h"

#include "mesh/seen_triangles.h"
#include "surface/surface_colors.h"

#include <algorithm>
#include <cstdint>

namespace tetrec {
namespace {

// Rays in memory at once, 8 bytes each: large pictures are drawn in bands of rows.
constexpr int64_t kMostRays = int64_t{1} << 22;

// Appends these rows of pixels to the picture.
void DrawRows(const TriangleMesh& mesh, const SurfaceColors& color_at, const Camera& camera,
              const Rigid3& cam_from_world, int rays_per_side, int begin, int end,
              SurfacePicture& picture) {
  Camera rays = WithRaysAsPixels(camera, rays_per_side);
  rays.height = (end - begin) * rays_per_side;
  rays.cy -= begin * rays_per_side;
  const SeenTriangles seen = FindSeenTriangles(mesh, rays, cam_from_world);
  const int rays_per_pixel = rays_per_side * rays_per_side;
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      glm::vec3 sum(0.0f);
      int hits = 0;
      for (int ray = 0; ray < rays_per_pixel; ++ray) {
        const int i = x * rays_per_side + ray % rays_per_side,
                  j = (y - begin) * rays_per_side + ray / rays_per_side;
        const uint32_t triangle = seen.triangle[seen.Index(i, j)];
        if (triangle == kNoTriangle) continue;
        const glm::dvec3 weights =
            CornerWeights(mesh, triangle, rays, cam_from_world, glm::dvec2(i, j) + 0.5);
        sum += color_at(triangle, glm::vec3(weights));
        ++hits;
      }
      picture.covered.push_back(hits == rays_per_pixel);
      if (hits > 0) SetColor(picture.image, x, y, sum / float(hits));
    }
  }
}

}  // namespace

void SetColor(Image& image, int x, int y, const glm::vec3& color) {
  const glm::vec3 levels = glm::round(255.0f * glm::clamp(color, 0.0f, 1.0f));
  for (int c = 0; c < 3; ++c) image.At(x, y)[c] = uint8_t(levels[c]);
}

Camera WithRaysAsPixels(const Camera& camera, int rays_per_side) {
  return camera.Resized(camera.width * rays_per_side, camera.height * rays_per_side);
}

SurfacePicture DrawSurface(const TriangleMesh& mesh, const Image& texture, const Camera& camera,
                           const Rigid3& cam_from_world, int rays_per_side) {
  SurfacePicture picture{MakeImage(camera.width, camera.height, 3), {}};
  const std::vector<glm::vec3> of_vertices =
      texture.pixels.empty() ? VertexColors(mesh) : std::vector<glm::vec3>();
  const SurfaceColors color_at =
      texture.pixels.empty() ? ColorsOfVertices(mesh, of_vertices) : ColorsOfTexture(mesh, texture);
  const int64_t rays_per_row = int64_t{camera.width} * rays_per_side * rays_per_side;
  const int rows = int(std::max<int64_t>(1, kMostRays / rays_per_row));
  for (int begin = 0; begin < camera.height; begin += rows) {
    DrawRows(mesh, color_at, camera, cam_from_world, rays_per_side, begin,
             std::min(begin + rows, camera.height), picture);
  }
  return picture;
}

}  // namespace tetrec
