// A z-buffer of triangles.
#include "mesh/seen_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace tetrec {
namespace {

// For the ray through the camera's centre with direction d, dot(edge[i], d) is proportional to the
// weight of corner i, and depth = volume / (sum of the three) if d.z = 1.
struct HomogeneousTriangle {
  glm::dvec3 corners[3];  // in the camera frame
  glm::dvec3 edges[3];
  double volume;

  HomogeneousTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
      : corners{a, b, c} {
    // Neighbours compute the same vector with the opposite sign, so no pixel falls between them.
    for (int i = 0; i < 3; ++i) edges[i] = glm::cross(corners[(i + 1) % 3], corners[(i + 2) % 3]);
    volume = glm::dot(corners[0], edges[0]);
  }
};

// A vertex in a camera's frame, and where the image shows it if it is in front of the camera.
struct SeenVertex {
  glm::dvec3 in_cam;
  glm::dvec2 pixel;

  bool is_behind() const { return !(in_cam.z > 0); }
};

std::vector<SeenVertex> VerticesIn(const TriangleMesh& mesh, const Camera& camera,
                                   const Rigid3& cam_from_mesh) {
  std::vector<SeenVertex> vertices;
  vertices.reserve(mesh.positions.size());
  for (const glm::vec3& position : mesh.positions) {
    const glm::dvec3 in_cam = cam_from_mesh * glm::dvec3(position);
    vertices.push_back({in_cam, camera.ImageFromCam(in_cam)});
  }
  return vertices;
}

struct PixelBox {
  int x_begin, x_end, y_begin, y_end;

  bool IsEmpty() const { return x_begin >= x_end || y_begin >= y_end; }
};

// A rectangle of the image plane [px], which may reach to infinity.
struct Extent {
  glm::dvec2 low{std::numeric_limits<double>::infinity()}, high = -low;

  void Add(const glm::dvec2& pixel) {
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  // An edge that ends behind the camera reaches to infinity in the picture, in the direction of the
  // point at which it crosses the camera's plane; to both sides where rounding hides which.
  void AddCrossingEdge(const glm::dvec3& in_front, const glm::dvec3& behind) {
    constexpr double kRounding = 1e-12;
    for (int axis = 0; axis < 2; ++axis) {
      const double a = behind[axis] * in_front.z, b = -in_front[axis] * behind.z;
      const double margin = kRounding * (std::abs(a) + std::abs(b));
      if (a + b <= margin) low[axis] = -std::numeric_limits<double>::infinity();
      if (a + b >= -margin) high[axis] = std::numeric_limits<double>::infinity();
    }
  }
};

Extent ExtentOf(const std::array<SeenVertex, 3>& corners) {
  Extent extent;
  for (const SeenVertex& corner : corners) {
    if (corner.is_behind()) continue;
    extent.Add(corner.pixel);
    for (const SeenVertex& other : corners) {
      if (other.is_behind()) extent.AddCrossingEdge(corner.in_cam, other.in_cam);
    }
  }
  return extent;
}

// The pixels whose centres may be inside the part of the triangle in front of the camera, up to
// rounding. Small triangles often have none.
PixelBox BoxOf(const std::array<SeenVertex, 3>& corners, const Camera& camera) {
  constexpr double kRounding = 1e-3;  // [px]
  const Extent extent = ExtentOf(corners);
  // Values are clamped before the conversion to int, which then rounds down. std::ceil and
  // std::floor are slow on x86-64 without SSE 4.1, for which the programs are built.
  const auto begin = [](double least, int size) {
    const double position = std::clamp(least - 0.5 - kRounding, 0.0, double(size));
    const int below = int(position);
    return below + int(below < position);
  };
  const auto end = [](double most, int size) {
    return int(std::clamp(most + 0.5 + kRounding, 0.0, double(size)));
  };
  return {begin(extent.low.x, camera.width), end(extent.high.x, camera.width),
          begin(extent.low.y, camera.height), end(extent.high.y, camera.height)};
}

// A corner's weight by pixel: it is linear over the image.
struct PixelWeight {
  double per_column, per_row, at_origin;

  // Changes of sign are exact in every step, so that neighbours still have opposite weights.
  PixelWeight(const glm::dvec3& edge, double sign, const Camera& camera,
              const glm::dvec2& per_focal)
      : per_column(sign * edge.x * per_focal.x),
        per_row(sign * edge.y * per_focal.y),
        at_origin(sign * edge.z + (0.5 - camera.cx) * per_column + (0.5 - camera.cy) * per_row) {}
};

void Draw(const HomogeneousTriangle& t, uint32_t id, const PixelBox& box, const Camera& camera,
          SeenTriangles& seen) {
  const double sign = t.volume > 0 ? 1 : -1, volume = std::abs(t.volume);
  const glm::dvec2 per_focal(1 / camera.fx, 1 / camera.fy);
  const PixelWeight a(t.edges[0], sign, camera, per_focal), b(t.edges[1], sign, camera, per_focal),
      c(t.edges[2], sign, camera, per_focal);
  const auto in_row = [](const PixelWeight& weight, int y) {
    return weight.at_origin + y * weight.per_row;
  };
  for (int y = box.y_begin; y < box.y_end; ++y) {
    const double a_row = in_row(a, y), b_row = in_row(b, y), c_row = in_row(c, y);
    bool inside = false;
    for (int x = box.x_begin; x < box.x_end; ++x) {
      const double a_here = a_row + x * a.per_column, b_here = b_row + x * b.per_column,
                   c_here = c_row + x * c.per_column;
      // One branch, which is hard to predict, instead of three.
      if (!(std::min({a_here, b_here, c_here}) >= 0)) {
        if (inside) break;  // a triangle has no gaps
        continue;
      }
      inside = true;
      const float depth = float(volume / (a_here + b_here + c_here));  // infinite if all are 0
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
  const std::vector<SeenVertex> vertices = VerticesIn(mesh, camera, cam_from_mesh);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& ids = mesh.triangles[i];
    const std::array<SeenVertex, 3> corners{vertices[ids.x], vertices[ids.y], vertices[ids.z]};
    const PixelBox box = BoxOf(corners, camera);
    if (box.IsEmpty()) continue;
    const HomogeneousTriangle triangle(corners[0].in_cam, corners[1].in_cam, corners[2].in_cam);
    if (triangle.volume != 0) Draw(triangle, uint32_t(i), box, camera, seen);
  }
  return seen;
}

glm::dvec3 CornerWeights(const std::array<glm::dvec3, 3>& corners_in_cam, const Camera& camera,
                         const glm::dvec2& pixel) {
  const HomogeneousTriangle t(corners_in_cam[0], corners_in_cam[1], corners_in_cam[2]);
  const glm::dvec3 ray = camera.CamFromImage(pixel);
  const glm::dvec3 weights(glm::dot(t.edges[0], ray), glm::dot(t.edges[1], ray),
                           glm::dot(t.edges[2], ray));
  const double sum = weights.x + weights.y + weights.z;
  return sum != 0 ? weights / sum : glm::dvec3(1.0 / 3);
}

glm::dvec3 CornerWeights(const TriangleMesh& mesh, uint32_t triangle, const Camera& camera,
                         const Rigid3& cam_from_mesh, const glm::dvec2& pixel) {
  const auto corner = [&](int i) {
    return cam_from_mesh * glm::dvec3(mesh.positions[mesh.triangles[triangle][i]]);
  };
  return CornerWeights({corner(0), corner(1), corner(2)}, camera, pixel);
}

}  // namespace tetrec
