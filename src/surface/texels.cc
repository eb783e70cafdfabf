// Triangles are drawn into the texture with a rim.
#include "surface/texels.h"

#include "surface/side_of_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

glm::dvec2 PointAt(const std::array<glm::dvec2, 3>& corners, const glm::dvec3& weights) {
  return weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
}

}  // namespace

glm::dvec3 NearestWeights(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& p) {
  const double area = SideOfLine(corners[0], corners[1], corners[2]);
  if (area != 0) {
    const glm::dvec3 inside{SideOfLine(corners[1], corners[2], p) / area,
                            SideOfLine(corners[2], corners[0], p) / area,
                            SideOfLine(corners[0], corners[1], p) / area};
    if (inside.x >= 0 && inside.y >= 0 && inside.z >= 0) return inside;
  }
  glm::dvec3 best(1.0, 0.0, 0.0);
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const glm::dvec2 a = corners[size_t(k)], along = corners[size_t(k + 1) % 3] - a;
    const double squared = glm::dot(along, along);
    const double t = squared > 0 ? std::clamp(glm::dot(p - a, along) / squared, 0.0, 1.0) : 0.0;
    const glm::dvec2 offset = p - (a + t * along);
    if (const double distance = glm::dot(offset, offset); distance < least) {
      least = distance;
      best = glm::dvec3(0.0);
      best[k] = 1 - t;
      best[(k + 1) % 3] = t;
    }
  }
  return best;
}

Texels FindTexels(const TextureLayout& layout) {
  Texels texels{layout.size, {}};
  const size_t count = size_t(layout.size) * size_t(layout.size);
  texels.triangle.assign(count, kNoTriangle);
  std::vector<float> distance(count, float(kTexturePadding));
  const auto texel = [&](double value) {
    return int(std::clamp(value, 0.0, double(layout.size - 1)));
  };
  for (size_t t = 0; t < layout.corners.size(); ++t) {
    const auto& corners = layout.corners[t];
    const glm::dvec2 low = glm::min(corners[0], glm::min(corners[1], corners[2])),
                     high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    constexpr double kRim = kTexturePadding;
    for (int y = texel(low.y - kRim); y <= texel(high.y + kRim); ++y) {
      for (int x = texel(low.x - kRim); x <= texel(high.x + kRim); ++x) {
        const glm::dvec2 p(x + 0.5, y + 0.5);
        const size_t i = size_t(y) * size_t(layout.size) + size_t(x);
        if (distance[i] == 0) continue;
        const auto away = float(glm::distance(p, PointAt(corners, NearestWeights(corners, p))));
        // The point of a triangle that contains the texel may be off by rounding.
        if (away < distance[i]) {
          distance[i] = away < 1e-4f ? 0 : away;
          texels.triangle[i] = uint32_t(t);
        }
      }
    }
  }
  return texels;
}

}  // namespace tetrec
