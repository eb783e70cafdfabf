// A z-buffer, and the mean over the rays of a pixel.
#include "surface/draw_surface.h"

#include "image/pixels_around.h"
#include "mesh/seen_triangles.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

Camera WithRaysAsPixels(const Camera& camera) {
  return camera.Resized(camera.width * kRaysPerSide, camera.height * kRaysPerSide);
}

SurfacePicture DrawSurface(const TriangleMesh& mesh, const Image& texture, const Camera& camera,
                           const Rigid3& cam_from_world) {
  const Camera finer = WithRaysAsPixels(camera);
  const SeenTriangles seen = FindSeenTriangles(mesh, finer, cam_from_world);
  SurfacePicture picture{MakeImage(camera.width, camera.height, 3), {}};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      glm::dvec3 sum(0.0);
      int hits = 0;
      for (int ray = 0; ray < kRaysPerSide * kRaysPerSide; ++ray) {
        const int i = x * kRaysPerSide + ray % kRaysPerSide,
                  j = y * kRaysPerSide + ray / kRaysPerSide;
        const uint32_t triangle = seen.triangle[seen.Index(i, j)];
        if (triangle == kNoTriangle) continue;
        const glm::dvec3 weights =
            CornerWeights(mesh, triangle, finer, cam_from_world, glm::dvec2(i, j) + 0.5);
        sum += ColorOf(mesh, texture, triangle, weights);
        ++hits;
      }
      picture.covered.push_back(hits == kRaysPerSide * kRaysPerSide);
      for (int c = 0; c < 3 && hits > 0; ++c) {
        picture.image.At(x, y)[c] = uint8_t(std::lround(std::clamp(sum[c] / hits, 0.0, 255.0)));
      }
    }
  }
  return picture;
}

}  // namespace tetrec
