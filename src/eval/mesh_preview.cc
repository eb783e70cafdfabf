// Turntable images: orthographic z-buffer, supersampled 2 x 2.
#include "eval/mesh_preview.h"

#include "core/parallel.h"
#include "geometry/look_at.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

constexpr int kSupersampling = 2;
constexpr double kFill = 0.96;  // share of the image's width that the mesh fills
constexpr glm::dvec3 kClay(0.80, 0.78, 0.75), kBackSide(0.45, 0.52, 0.66),
    kPaper(0.955, 0.955, 0.95);

// Rows are the image's x (right), y (down) and z (away from the viewer).
glm::dmat3 ViewRotation(const PreviewOptions& options, int step) {
  const glm::dvec3 up = glm::normalize(options.up);
  // The axis that `up` has least of gives a stable first direction.
  glm::dvec3 seed(0.0);
  int least = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(up[axis]) < std::abs(up[least])) least = axis;
  }
  seed[least] = 1;
  const glm::dvec3 side = glm::normalize(glm::cross(up, seed)), front = glm::cross(side, up);
  const double turn = 2 * M_PI * step / options.views, rise = options.elevation_deg * M_PI / 180;
  const glm::dvec3 to_viewer =
      std::cos(rise) * (std::cos(turn) * front + std::sin(turn) * side) + std::sin(rise) * up;
  return CamFromWorldRotation(-to_viewer, up);
}

struct Corner {
  glm::dvec3 position;  // x, y [px], z [px] away from the viewer
  glm::dvec3 color;
};

struct Canvas {
  Image image;
  std::vector<double> depth;

  explicit Canvas(int size) : image{size, size, 3, {}}, depth(size_t(size) * size) {
    std::fill(depth.begin(), depth.end(), std::numeric_limits<double>::infinity());
    image.pixels.resize(depth.size() * 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) {
      image.pixels[i] = uint8_t(std::lround(255 * kPaper[int(i % 3)]));
    }
  }
  void Set(int x, int y, double z, const glm::dvec3& color) {
    double& nearest = depth[size_t(y) * image.width + x];
    if (z >= nearest) return;
    nearest = z;
    for (int c = 0; c < 3; ++c) {
      image.At(x, y)[c] = uint8_t(std::lround(255 * std::clamp(color[c], 0.0, 1.0)));
    }
  }
};

double Cross(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// `ambient`: share of the light that comes from all directions; the rest comes from the viewer.
void DrawTriangle(Canvas& canvas, const std::array<Corner, 3>& t, double ambient) {
  const double area = Cross(t[0].position, t[1].position, t[2].position);
  if (area == 0 || !std::isfinite(area)) return;
  const glm::dvec3 normal =
      glm::normalize(glm::cross(t[1].position - t[0].position, t[2].position - t[0].position));
  // y points down, so triangles that face the viewer are clockwise on the screen: z < 0.
  const bool front = normal.z < 0;
  const double light = ambient + (1 - ambient) * std::abs(normal.z);
  const auto low = [&](int axis) {
    return std::min({t[0].position[axis], t[1].position[axis], t[2].position[axis]});
  };
  const auto high = [&](int axis) {
    return std::max({t[0].position[axis], t[1].position[axis], t[2].position[axis]});
  };
  const auto clamped = [&](double value) {
    return int(std::clamp(value, 0.0, double(canvas.image.width)));
  };
  const int x_end = clamped(std::ceil(high(0))), y_end = clamped(std::ceil(high(1)));
  for (int y = clamped(std::floor(low(1))); y < y_end; ++y) {
    for (int x = clamped(std::floor(low(0))); x < x_end; ++x) {
      const glm::dvec3 p(x + 0.5, y + 0.5, 0);
      const double w0 = Cross(t[1].position, t[2].position, p) / area;
      const double w1 = Cross(t[2].position, t[0].position, p) / area;
      const double w2 = 1 - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const double z = w0 * t[0].position.z + w1 * t[1].position.z + w2 * t[2].position.z;
      const glm::dvec3 color =
          front ? w0 * t[0].color + w1 * t[1].color + w2 * t[2].color : kBackSide;
      canvas.Set(x, y, z, light * color);
    }
  }
}

// Largest distance of a drawn vertex from the centre, shared by all steps so that the scale is
// constant.
double RadiusOf(const TriangleMesh& mesh, const Bounds3& bounds) {
  double squared = 0;
  for (const glm::vec3& vertex : mesh.positions) {
    const glm::dvec3 position(vertex), offset = position - bounds.Center();
    if (bounds.Contains(position)) squared = std::max(squared, glm::dot(offset, offset));
  }
  return std::sqrt(squared);
}

Image RenderStep(const TriangleMesh& mesh, const PreviewOptions& options, double radius, int step) {
  const int size = options.size_px * kSupersampling;
  const glm::dmat3 rotation = ViewRotation(options, step);
  const glm::dvec3 center = options.bounds.Center();
  const double scale = radius > 0 ? 0.5 * kFill * size / radius : 1;
  const bool colored = options.use_colors && mesh.colors_srgb.size() == mesh.positions.size();
  // The field's colours come from photographs and already include shading.
  const double ambient = colored ? 0.7 : 0.3;
  Canvas canvas(size);
  for (const glm::uvec3& triangle : mesh.triangles) {
    std::array<Corner, 3> corners;
    glm::dvec3 centroid(0.0);
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 position(mesh.positions[triangle[i]]);
      centroid += position / 3.0;
      corners[i].position = scale * (rotation * (position - center));
      corners[i].position.x += 0.5 * size;
      corners[i].position.y += 0.5 * size;
      corners[i].color = kClay;
      if (colored) {
        const auto& rgb = mesh.colors_srgb[triangle[i]];
        corners[i].color = glm::dvec3(rgb[0], rgb[1], rgb[2]) / 255.0;
      }
    }
    if (options.bounds.Contains(centroid)) DrawTriangle(canvas, corners, ambient);
  }
  return ResizeByArea(canvas.image, options.size_px, options.size_px);
}

}  // namespace

std::vector<Image> RenderTurntable(const TriangleMesh& mesh, const PreviewOptions& options) {
  const double radius = RadiusOf(mesh, options.bounds);
  std::vector<Image> pictures(options.views);
  ParallelFor(pictures.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) pictures[i] = RenderStep(mesh, options, radius, int(i));
  });
  return pictures;
}

}  // namespace tetrec
