// How far a texture is from the paint of its surface.
#pragma once

#include "surface/texels.h"
#include "surface/textured_shapes.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

struct TexelError {
  double texture = 0, vertex_colors = 0;  // mean over texels inside triangles, of 0 to 1
  double worst = 0;                       // of the texture
};

inline TexelError ErrorOf(const TriangleMesh& mesh, const TextureLayout& layout, const Image& image,
                          const Paint& paint) {
  TexelError error;
  double count = 0;
  const Texels texels = FindTexels(layout);
  for (int y = 0; y < layout.size; ++y) {
    for (int x = 0; x < layout.size; ++x) {
      const uint32_t t = texels.triangle[size_t(y) * size_t(layout.size) + size_t(x)];
      if (t == kNoTriangle) continue;
      const glm::dvec3 weights = NearestWeights(layout.corners[t], {x + 0.5, y + 0.5});
      glm::dvec3 point(0.0);
      for (int k = 0; k < 3; ++k) {
        point += weights[k] * glm::dvec3(mesh.positions[mesh.triangles[t][k]]);
      }
      const glm::dvec3 truth = paint(point);
      double off = 0, plain = 0;
      for (int c = 0; c < 3; ++c) {
        off += std::abs(image.At(x, y)[c] / 255.0 - truth[c]) / 3;
        plain += std::abs(128 / 255.0 - truth[c]) / 3;
      }
      error.texture += off;
      error.vertex_colors += plain;
      error.worst = std::max(error.worst, off);
      ++count;
    }
  }
  error.texture /= count;
  error.vertex_colors /= count;
  return error;
}

}  // namespace tetrec
