// A z-buffer, and the mean over the rays of a pixel.
#include "surface/draw_surface.h"

#include "image/pixels_around.h"
#include "mesh/seen_triangles.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tetrec {
namespace {

// Bilinear between texels' centres; coordinates as TriangleMesh has them.
glm::dvec3 TextureColor(const Image& texture, const glm::dvec2& coordinates) {
  glm::dvec3 color(0.0);
  const glm::dvec2 texel(coordinates.x * texture.width, (1 - coordinates.y) * texture.height);
  for (const auto& [x, y, weight] : PixelsAround(texture.width, texture.height, texel)) {
    if (weight == 0) continue;
    const uint8_t* rgb = texture.At(x, y);
    color += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
  }
  return color;
}

glm::dvec3 ColorOf(const TriangleMesh& mesh, const Image& texture, uint32_t triangle,
                   const glm::dvec3& weights) {
  if (texture.pixels.empty() && mesh.colors_srgb.empty()) return glm::dvec3(128);
  glm::dvec3 color(0.0);
  glm::dvec2 coordinates(0.0);
  for (int k = 0; k < 3; ++k) {
    if (!texture.pixels.empty()) {
      coordinates += weights[k] * glm::dvec2(mesh.corner_coordinates[triangle][size_t(k)]);
    } else {
      const auto& rgb = mesh.colors_srgb[mesh.triangles[triangle][k]];
      color += weights[k] * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    }
  }
  return texture.pixels.empty() ? color : TextureColor(texture, coordinates);
}

// Rays in memory at once, 8 bytes each: large pictures are drawn in bands of rows.
constexpr int64_t kMostRays = int64_t{1} << 22;

// Appends these rows of pixels to the picture.
void DrawRows(const TriangleMesh& mesh, const Image& texture, const Camera& camera,
              const Rigid3& cam_from_world, int rays_per_side, int begin, int end,
              SurfacePicture& picture) {
  Camera rays = WithRaysAsPixels(camera, rays_per_side);
  rays.height = (end - begin) * rays_per_side;
  rays.cy -= begin * rays_per_side;
  const SeenTriangles seen = FindSeenTriangles(mesh, rays, cam_from_world);
  const int rays_per_pixel = rays_per_side * rays_per_side;
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      glm::dvec3 sum(0.0);
      int hits = 0;
      for (int ray = 0; ray < rays_per_pixel; ++ray) {
        const int i = x * rays_per_side + ray % rays_per_side,
                  j = (y - begin) * rays_per_side + ray / rays_per_side;
        const uint32_t triangle = seen.triangle[seen.Index(i, j)];
        if (triangle == kNoTriangle) continue;
        const glm::dvec3 weights =
            CornerWeights(mesh, triangle, rays, cam_from_world, glm::dvec2(i, j) + 0.5);
        sum += ColorOf(mesh, texture, triangle, weights);
        ++hits;
      }
      picture.covered.push_back(hits == rays_per_pixel);
      for (int c = 0; c < 3 && hits > 0; ++c) {
        picture.image.At(x, y)[c] = uint8_t(std::lround(std::clamp(sum[c] / hits, 0.0, 255.0)));
      }
    }
  }
}

}  // namespace

Camera WithRaysAsPixels(const Camera& camera, int rays_per_side) {
  return camera.Resized(camera.width * rays_per_side, camera.height * rays_per_side);
}

SurfacePicture DrawSurface(const TriangleMesh& mesh, const Image& texture, const Camera& camera,
                           const Rigid3& cam_from_world, int rays_per_side) {
  SurfacePicture picture{MakeImage(camera.width, camera.height, 3), {}};
  const int64_t rays_per_row = int64_t{camera.width} * rays_per_side * rays_per_side;
  const int rows = int(std::max<int64_t>(1, kMostRays / rays_per_row));
  for (int begin = 0; begin < camera.height; begin += rows) {
    DrawRows(mesh, texture, camera, cam_from_world, rays_per_side, begin,
             std::min(begin + rows, camera.height), picture);
  }
  return picture;
}

}  // namespace tetrec
