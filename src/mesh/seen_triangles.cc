// A z-buffer of triangles.
#include "mesh/seen_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

// For the ray through the camera's centre with direction d, dot(edge[i], d) is proportional to the
// weight of corner i, and depth = volume / (sum of the three) if d.z = 1.
struct HomogeneousTriangle {
  glm::dvec3 corners[3];  // in the camera frame
  glm::dvec3 edges[3];
  double volume;

  HomogeneousTriangle(const TriangleMesh& mesh, uint32_t triangle, const Rigid3& cam_from_mesh) {
    for (int i = 0; i < 3; ++i) {
      corners[i] = cam_from_mesh * glm::dvec3(mesh.positions[mesh.triangles[triangle][i]]);
    }
    // Neighbours compute the same vector with the opposite sign, so no pixel falls between them.
    for (int i = 0; i < 3; ++i) edges[i] = glm::cross(corners[(i + 1) % 3], corners[(i + 2) % 3]);
    volume = glm::dot(corners[0], edges[0]);
  }
};

struct PixelBox {
  int x_begin, x_end, y_begin, y_end;
};

// The pixels whose centres may be inside the triangle; all of them if it crosses the camera's
// plane.
PixelBox BoxOf(const HomogeneousTriangle& t, const Camera& camera) {
  const auto behind = [](const glm::dvec3& p) { return !(p.z > 0); };
  const auto count = std::count_if(std::begin(t.corners), std::end(t.corners), behind);
  if (count == 3) return {0, 0, 0, 0};
  if (count > 0) return {0, camera.width, 0, camera.height};
  glm::dvec2 low(std::numeric_limits<double>::infinity()), high = -low;
  for (const glm::dvec3& corner : t.corners) {
    const glm::dvec2 pixel = camera.ImageFromCam(corner);
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  const auto clamped = [](double value, int size) {
    return int(std::clamp(value, 0.0, double(size)));
  };
  return {clamped(std::floor(low.x), camera.width), clamped(std::ceil(high.x), camera.width),
          clamped(std::floor(low.y), camera.height), clamped(std::ceil(high.y), camera.height)};
}

void Draw(const HomogeneousTriangle& t, uint32_t id, const Camera& camera, SeenTriangles& seen) {
  const double sign = t.volume > 0 ? 1 : -1;
  const PixelBox box = BoxOf(t, camera);
  for (int y = box.y_begin; y < box.y_end; ++y) {
    for (int x = box.x_begin; x < box.x_end; ++x) {
      const glm::dvec3 ray = camera.CamFromImage({x + 0.5, y + 0.5});
      double sum = 0;
      bool inside = true;
      for (const glm::dvec3& edge : t.edges) {
        const double weight = sign * glm::dot(edge, ray);
        inside = inside && weight >= 0;
        sum += weight;
      }
      if (!inside || !(sum > 0)) continue;
      const float depth = float(std::abs(t.volume) / sum);
      const size_t index = seen.Index(x, y);
      if (depth < seen.depth[index]) {
        seen.depth[index] = depth;
        seen.triangle[index] = id;
      }
    }
  }
}

}  // namespace

SeenTriangles FindSeenTriangles(const TriangleMesh& mesh, const Camera& camera,
                                const Rigid3& cam_from_mesh) {
  SeenTriangles seen{camera.width, camera.height, {}, {}};
  const size_t pixels = size_t(camera.width) * size_t(camera.height);
  seen.triangle.assign(pixels, kNoTriangle);
  seen.depth.assign(pixels, std::numeric_limits<float>::infinity());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const HomogeneousTriangle triangle(mesh, uint32_t(i), cam_from_mesh);
    if (triangle.volume != 0) Draw(triangle, uint32_t(i), camera, seen);
  }
  return seen;
}

glm::dvec3 CornerWeights(const TriangleMesh& mesh, uint32_t triangle, const Camera& camera,
                         const Rigid3& cam_from_mesh, const glm::dvec2& pixel) {
  const HomogeneousTriangle t(mesh, triangle, cam_from_mesh);
  const glm::dvec3 ray = camera.CamFromImage(pixel);
  const glm::dvec3 weights(glm::dot(t.edges[0], ray), glm::dot(t.edges[1], ray),
                           glm::dot(t.edges[2], ray));
  const double sum = weights.x + weights.y + weights.z;
  return sum != 0 ? weights / sum : glm::dvec3(1.0 / 3);
}

}  // namespace tetrec
