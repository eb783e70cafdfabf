// Pictures in the colours of vertices, their errors, and the errors' derivatives.
#include "surface/photo_differences.h"

#include "core/parallel.h"
#include "core/stop_request.h"
#include "mesh/seen_triangles.h"
#include "surface/draw_surface.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace tetrec {
namespace {

// Groups of photos are summed up in parallel. Their number is fixed, so that the sums are the same
// on any number of cores.
constexpr size_t kGroups = 4;
// A ray that ends farther behind the nearest one around it than this many footprints meets the
// background.
constexpr float kJumpFootprints = 8;
constexpr float kShareOfRay = 1.0f / (kRaysPerSide * kRaysPerSide);

struct Picture {
  Camera rays;  // whose pixels are the rays
  SeenTriangles seen;
  std::vector<glm::vec4> pixels;  // RGBA, multiplied by alpha
  std::vector<uint8_t> hits;      // rays of the pixel that meet the surface
  std::vector<bool> open;  // pixels that show the surface's back, or a triangle at its border
};

// The shares of the triangle's vertices in the point that a ray meets. For a triangle that is seen
// edge-on, rounding may leave nothing of them.
glm::vec3 SharesAt(const TriangleMesh& mesh, const TexturePhoto& photo, const Picture& picture,
                   uint32_t triangle, int i, int j) {
  const glm::dvec3 shares = glm::max(
      CornerWeights(mesh, triangle, picture.rays, photo.cam_from_world, glm::dvec2(i, j) + 0.5),
      0.0);
  const double sum = shares.x + shares.y + shares.z;
  return sum > 0 ? glm::vec3(shares / sum) : glm::vec3(1.0f / 3);
}

// Calls body(i, j, triangle) for the rays of a pixel that meet the surface.
template <class Body>
void ForEachHit(const Picture& picture, int x, int y, const Body& body) {
  for (int j = y * kRaysPerSide; j < (y + 1) * kRaysPerSide; ++j) {
    for (int i = x * kRaysPerSide; i < (x + 1) * kRaysPerSide; ++i) {
      const uint32_t triangle = picture.seen.triangle[picture.seen.Index(i, j)];
      if (triangle != kNoTriangle) body(i, j, triangle);
    }
  }
}

bool ShowsBack(const TriangleMesh& mesh, const glm::uvec3& triangle, const glm::dvec3& eye) {
  return glm::dot(DoubleAreaNormal(mesh, triangle), glm::dvec3(mesh.positions[triangle.x]) - eye) >
         0;
}

Picture Draw(const TriangleMesh& mesh, const std::vector<bool>& border,
             std::span<const glm::vec3> colors, const TexturePhoto& photo) {
  Picture picture{
      .rays = WithRaysAsPixels(photo.camera), .seen = {}, .pixels = {}, .hits = {}, .open = {}};
  picture.seen = FindSeenTriangles(mesh, picture.rays, photo.cam_from_world);
  const glm::dvec3 eye = photo.cam_from_world.Inverse().translation;
  const size_t pixels = size_t(photo.camera.width) * size_t(photo.camera.height);
  picture.pixels.reserve(pixels);
  picture.hits.reserve(pixels);
  for (int y = 0; y < photo.camera.height; ++y) {
    for (int x = 0; x < photo.camera.width; ++x) {
      glm::vec4 pixel(0.0f);
      uint8_t hits = 0;
      bool open = false;
      ForEachHit(picture, x, y, [&](int i, int j, uint32_t triangle) {
        const glm::vec3 shares = SharesAt(mesh, photo, picture, triangle, i, j);
        const glm::uvec3& t = mesh.triangles[triangle];
        pixel += kShareOfRay *
                 glm::vec4(shares.x * colors[t.x] + shares.y * colors[t.y] + shares.z * colors[t.z],
                           1.0f);
        ++hits;
        open = open || border[t.x] || border[t.y] || border[t.z] || ShowsBack(mesh, t, eye);
      });
      picture.pixels.push_back(pixel);
      picture.hits.push_back(hits);
      picture.open.push_back(open);
    }
  }
  return picture;
}

// The sums of a group of photos.
class Differences {
 public:
  // Both must outlive this.
  Differences(const TriangleMesh& mesh, const std::vector<bool>& border)
      : mesh_(mesh), border_(border), vertices_(mesh.positions.size()) {}

  void Add(const TexturePhoto& photo, std::span<const glm::vec3> colors) {
    const Picture picture = Draw(mesh_, border_, colors, photo);
    for (int y = 1; y + 1 < photo.camera.height; ++y) {
      for (int x = 1; x + 1 < photo.camera.width; ++x) {
        if (Compares(photo, picture, x, y)) AddPixel(photo, picture, x, y);
      }
    }
  }

  void Add(const Differences& other) {
    for (size_t v = 0; v < vertices_.size(); ++v) vertices_[v] += other.vertices_[v];
    squared_error_ += other.squared_error_;
    values_ += other.values_;
  }

  PhotoDifferences Result() && {
    return {std::move(vertices_), values_ > 0 ? squared_error_ / values_ : 0};
  }

 private:
  static bool Fills(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    return picture.hits[photo.Index(x, y)] == kRaysPerSide * kRaysPerSide;
  }

  static bool NextToOpen(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    for (int row = y - 1; row <= y + 1; ++row) {
      for (int column = x - 1; column <= x + 1; ++column) {
        if (picture.open[photo.Index(column, row)]) return true;
      }
    }
    return false;
  }

  static bool Compares(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    if (NextToOpen(photo, picture, x, y)) return false;
    if (photo.alpha_is_opacity) {
      return picture.hits[photo.Index(x, y)] > 0 || photo.image.At(x, y)[3] > 0;
    }
    return photo.Counts(x, y) && Fills(photo, picture, x, y) && Fills(photo, picture, x - 1, y) &&
           Fills(photo, picture, x + 1, y) && Fills(photo, picture, x, y - 1) &&
           Fills(photo, picture, x, y + 1);
  }

  // The smallest depth of a pixel's rays and of those next to them.
  static float NearestDepth(const Picture& picture, int x, int y) {
    float nearest = std::numeric_limits<float>::infinity();
    for (int j = y * kRaysPerSide - 1; j <= (y + 1) * kRaysPerSide; ++j) {
      for (int i = x * kRaysPerSide - 1; i <= (x + 1) * kRaysPerSide; ++i) {
        nearest = std::min(nearest, picture.seen.depth[picture.seen.Index(i, j)]);
      }
    }
    return nearest;
  }

  void AddPixel(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    const auto at = [&](int column, int row) { return picture.pixels[photo.Index(column, row)]; };
    const float alpha = photo.alpha_is_opacity ? float(photo.image.At(x, y)[3]) / 255.0f : 1.0f;
    const glm::vec4 error = glm::vec4(alpha * glm::vec3(photo.ColorOf(x, y)), alpha) - at(x, y);
    const glm::vec4 along_x = 0.5f * (at(x + 1, y) - at(x - 1, y));
    const glm::vec4 along_y = 0.5f * (at(x, y + 1) - at(x, y - 1));
    squared_error_ += double(glm::dot(error, error));
    values_ += photo.alpha_is_opacity ? 4 : 3;
    const bool shows_nothing_else = alpha == 1.0f && Fills(photo, picture, x, y);
    const float nearest = NearestDepth(picture, x, y);
    const glm::mat3 world_from_cam(glm::transpose(photo.cam_from_world.rotation));
    const auto moves = [&](int i, int j) {
      const float depth = picture.seen.depth[picture.seen.Index(i, j)];
      return depth - nearest < kJumpFootprints * float(photo.Footprint(double(depth)));
    };
    int moving_rays = 0;
    ForEachHit(picture, x, y, [&](int i, int j, uint32_t) { moving_rays += moves(i, j); });
    ForEachHit(picture, x, y, [&](int i, int j, uint32_t triangle) {
      const float depth = picture.seen.depth[picture.seen.Index(i, j)];
      VertexDifferences ray;
      ray.footprint = float(photo.Footprint(double(depth)));
      ray.seen = 1;
      if (shows_nothing_else) ray.color_error = glm::vec3(error), ray.color_weight = 1;
      if (moves(i, j)) {
        // What the picture's content moves by, in pixels, as the point that the ray meets moves by
        // a footprint along the axes of the world.
        const glm::vec3 direction(picture.rays.CamFromImage(glm::dvec2(i, j) + 0.5));
        const float aspect = float(photo.camera.fy / photo.camera.fx);
        const glm::vec3 x_moves = world_from_cam * glm::vec3(1, 0, -direction.x);
        const glm::vec3 y_moves = world_from_cam * glm::vec3(0, aspect, -aspect * direction.y);
        for (int c = 0; c < 4; ++c) {
          const glm::vec3 derivative = -(along_x[c] * x_moves + along_y[c] * y_moves);
          ray.pull += error[c] * derivative;
          ray.curvature += glm::outerProduct(derivative, derivative);
        }
        // Together, they move the whole pixel.
        ray.pull /= kShareOfRay * float(moving_rays);
        ray.curvature /= kShareOfRay * float(moving_rays);
      }
      const glm::vec3 shares = kShareOfRay * SharesAt(mesh_, photo, picture, triangle, i, j);
      for (int k = 0; k < 3; ++k) AddShare(ray, shares[k], vertices_[mesh_.triangles[triangle][k]]);
    });
  }

  static void AddShare(const VertexDifferences& ray, float share, VertexDifferences& vertex) {
    vertex.pull += share * ray.pull;
    vertex.curvature += share * ray.curvature;
    vertex.color_error += share * ray.color_error;
    vertex.color_weight += share * ray.color_weight;
    vertex.footprint += share * ray.footprint;
    vertex.seen += share * ray.seen;
  }

  const TriangleMesh& mesh_;
  const std::vector<bool>& border_;
  std::vector<VertexDifferences> vertices_;
  double squared_error_ = 0, values_ = 0;  // values: channels of pixels
};

}  // namespace

VertexDifferences& VertexDifferences::operator+=(const VertexDifferences& other) {
  pull += other.pull;
  curvature += other.curvature;
  color_error += other.color_error;
  color_weight += other.color_weight;
  footprint += other.footprint;
  seen += other.seen;
  return *this;
}

PhotoDifferences CompareWithPhotos(const TriangleMesh& mesh, const std::vector<bool>& border,
                                   std::span<const glm::vec3> colors,
                                   std::span<const TexturePhoto> photos) {
  std::vector<Differences> groups(kGroups, Differences(mesh, border));
  ParallelForEach(kGroups, "", "the surface will be extracted again", [&](size_t group) {
    for (size_t i = group; i < photos.size(); i += kGroups) {
      ThrowIfStopRequested("the surface will be extracted again");
      groups[group].Add(photos[i], colors);
    }
  });
  for (size_t group = 1; group < kGroups; ++group) groups[0].Add(groups[group]);
  return std::move(groups[0]).Result();
}

}  // namespace tetrec
