// Pictures in the colours of vertices, their errors, and the errors' derivatives.
#include "surface/photo_differences.h"

#include "core/parallel.h"
#include "core/stop_request.h"
#include "mesh/seen_triangles.h"
#include "surface/draw_surface.h"
#include "surface/trained_views.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <array>
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
constexpr float kBackgroundFootprints = 8;
constexpr size_t kRaysPerPixel = kRaysPerSide * kRaysPerSide;
constexpr float kShareOfRay = 1.0f / float(kRaysPerPixel);

// A row of the picture's pixels.
struct PixelRow {
  std::vector<glm::vec4> pixels;  // RGBA, multiplied by alpha
  std::vector<uint8_t> hits;      // rays of the pixel that meet the surface
  std::vector<bool> open;  // pixels that show the surface's back, or a triangle at its border
  // (pixels x rays) shares of the triangle's vertices in the point that a ray meets.
  std::vector<glm::vec3> shares;
};

bool ShowsBack(const TriangleMesh& mesh, const glm::uvec3& triangle, const glm::dvec3& eye) {
  return glm::dot(DoubleAreaNormal(mesh, triangle), glm::dvec3(mesh.positions[triangle.x]) - eye) >
         0;
}

// A picture of the surface in the colours of its vertices, of which the last three rows are kept.
class Picture {
 public:
  // All must outlive this.
  Picture(const TriangleMesh& mesh, const std::vector<bool>& border,
          std::span<const glm::vec3> colors, const TexturePhoto& photo)
      : mesh_(mesh),
        border_(border),
        colors_(colors),
        photo_(photo),
        rays_(WithRaysAsPixels(photo.camera)),
        eye_(photo.cam_from_world.Inverse().translation),
        seen_(FindSeenTriangles(mesh, rays_, photo.cam_from_world)) {}

  void DrawRow(int y) {
    PixelRow& row = rows_[size_t(y) % rows_.size()];
    row.pixels.assign(size_t(photo_.camera.width), glm::vec4(0.0f));
    row.hits.assign(row.pixels.size(), 0);
    row.open.assign(row.pixels.size(), false);
    row.shares.assign(kRaysPerPixel * row.pixels.size(), glm::vec3(0.0f));
    for (int x = 0; x < photo_.camera.width; ++x) {
      const auto pixel = size_t(x);
      ForEachHit(x, y, [&](int ray, size_t index) {
        const uint32_t triangle = seen_.triangle[index];
        const glm::vec3 shares = SharesAt(triangle, x, y, ray);
        row.shares[kRaysPerPixel * pixel + size_t(ray)] = shares;
        const glm::uvec3& t = mesh_.triangles[triangle];
        row.pixels[pixel] +=
            kShareOfRay *
            glm::vec4(shares.x * colors_[t.x] + shares.y * colors_[t.y] + shares.z * colors_[t.z],
                      1.0f);
        ++row.hits[pixel];
        row.open[pixel] = row.open[pixel] || border_[t.x] || border_[t.y] || border_[t.z] ||
                          ShowsBack(mesh_, t, eye_);
      });
    }
  }

  // One of the three rows that were drawn last.
  const PixelRow& Row(int y) const { return rows_[size_t(y) % rows_.size()]; }

  const SeenTriangles& seen() const { return seen_; }  // by ray

  // Calls body(ray, index) for the rays of a pixel that meet the surface: their numbers within the
  // pixel and their indices in seen().
  template <class Body>
  void ForEachHit(int x, int y, const Body& body) const {
    for (int ray = 0; ray < int(kRaysPerPixel); ++ray) {
      const glm::ivec2 place = PlaceOf(x, y, ray);
      const size_t index = seen_.Index(place.x, place.y);
      if (seen_.triangle[index] != kNoTriangle) body(ray, index);
    }
  }

  // The smallest depth of a pixel's rays and of those next to them; not for pixels at the border.
  float NearestDepth(int x, int y) const {
    float nearest = std::numeric_limits<float>::infinity();
    for (int j = y * kRaysPerSide - 1; j <= (y + 1) * kRaysPerSide; ++j) {
      for (int i = x * kRaysPerSide - 1; i <= (x + 1) * kRaysPerSide; ++i) {
        nearest = std::min(nearest, seen_.depth[seen_.Index(i, j)]);
      }
    }
    return nearest;
  }

 private:
  static glm::ivec2 PlaceOf(int x, int y, int ray) {
    return {x * kRaysPerSide + ray % kRaysPerSide, y * kRaysPerSide + ray / kRaysPerSide};
  }

  // For a triangle that is seen edge-on, rounding may leave nothing of the weights.
  glm::vec3 SharesAt(uint32_t triangle, int x, int y, int ray) const {
    const glm::dvec3 shares = glm::max(CornerWeights(mesh_, triangle, rays_, photo_.cam_from_world,
                                                     glm::dvec2(PlaceOf(x, y, ray)) + 0.5),
                                       0.0);
    const double sum = shares.x + shares.y + shares.z;
    return sum > 0 ? glm::vec3(shares / sum) : glm::vec3(1.0f / 3);
  }

  const TriangleMesh& mesh_;
  const std::vector<bool>& border_;
  std::span<const glm::vec3> colors_;
  const TexturePhoto& photo_;
  Camera rays_;  // whose pixels are the rays
  glm::dvec3 eye_;
  SeenTriangles seen_;
  std::array<PixelRow, 3> rows_;
};

// By how many pixels a pixel's content moves along the axes of the photo as the point that it shows
// moves by a footprint along each axis of the world.
struct PixelMoves {
  glm::vec3 along_x, along_y;

  PixelMoves(const TexturePhoto& photo, int x, int y) {
    const glm::mat3 world_from_cam(glm::transpose(photo.cam_from_world.rotation));
    const glm::vec3 direction(photo.camera.CamFromImage(glm::dvec2(x, y) + 0.5));
    const float aspect = float(photo.camera.fy / photo.camera.fx);
    along_x = world_from_cam * glm::vec3(1, 0, -direction.x);
    along_y = world_from_cam * glm::vec3(0, aspect, -aspect * direction.y);
  }
};

// The sums of a group of photos.
class Differences {
 public:
  // Both must outlive this.
  Differences(const TriangleMesh& mesh, const std::vector<bool>& border)
      : mesh_(mesh), border_(border), vertices_(mesh.positions.size()) {}

  void Add(const TexturePhoto& photo, std::span<const glm::vec3> colors) {
    Picture picture(mesh_, border_, colors, photo);
    for (int below = 0; below < photo.camera.height; ++below) {
      picture.DrawRow(below);
      const int y = below - 1;
      if (y < 1) continue;
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
  static bool Fills(const Picture& picture, int x, int y) {
    return picture.Row(y).hits[size_t(x)] == kRaysPerPixel;
  }

  static bool NextToOpen(const Picture& picture, int x, int y) {
    for (int row = y - 1; row <= y + 1; ++row) {
      for (int column = x - 1; column <= x + 1; ++column) {
        if (picture.Row(row).open[size_t(column)]) return true;
      }
    }
    return false;
  }

  static bool Compares(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    if (NextToOpen(picture, x, y)) return false;
    if (photo.alpha_is_opacity) {
      return picture.Row(y).hits[size_t(x)] > 0 || photo.image.At(x, y)[3] > 0;
    }
    return photo.Counts(x, y) && Fills(picture, x, y) && Fills(picture, x - 1, y) &&
           Fills(picture, x + 1, y) && Fills(picture, x, y - 1) && Fills(picture, x, y + 1);
  }

  void AddPixel(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    const auto at = [&](int column, int row) { return picture.Row(row).pixels[size_t(column)]; };
    const float alpha = photo.alpha_is_opacity ? float(photo.image.At(x, y)[3]) / 255.0f : 1.0f;
    const glm::vec4 error = glm::vec4(alpha * glm::vec3(photo.ColorOf(x, y)), alpha) - at(x, y);
    squared_error_ += double(glm::dot(error, error));
    values_ += photo.alpha_is_opacity ? 4 : 3;

    VertexDifferences still{.seen = 1};
    if (alpha == 1.0f && Fills(picture, x, y)) {
      still.color_error = glm::vec3(error), still.color_weight = 1;
    }
    const float nearest = picture.NearestDepth(x, y);
    const auto moves = [&](size_t index) {
      const float depth = picture.seen().depth[index];
      return depth - nearest < kBackgroundFootprints * float(photo.Footprint(double(depth)));
    };
    int moving_rays = 0;
    picture.ForEachHit(x, y, [&](int, size_t index) { moving_rays += moves(index); });
    VertexDifferences moving = still;
    if (moving_rays > 0) {
      const PixelMoves content(photo, x, y);
      const glm::vec4 along_x = 0.5f * (at(x + 1, y) - at(x - 1, y));
      const glm::vec4 along_y = 0.5f * (at(x, y + 1) - at(x, y - 1));
      // Together, the moving rays move the whole pixel.
      const float part = 1 / (kShareOfRay * float(moving_rays));
      for (int c = 0; c < 4; ++c) {
        const glm::vec3 derivative = -(along_x[c] * content.along_x + along_y[c] * content.along_y);
        moving.pull += part * error[c] * derivative;
        moving.curvature += part * glm::outerProduct(derivative, derivative);
      }
    }
    picture.ForEachHit(x, y, [&](int ray, size_t index) {
      VertexDifferences& here = moves(index) ? moving : still;
      here.footprint = float(photo.Footprint(double(picture.seen().depth[index])));
      const glm::vec3 shares =
          kShareOfRay * picture.Row(y).shares[kRaysPerPixel * size_t(x) + size_t(ray)];
      const glm::uvec3& t = mesh_.triangles[picture.seen().triangle[index]];
      for (int k = 0; k < 3; ++k) AddShare(here, shares[k], vertices_[t[k]]);
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
  ParallelForEach(kGroups, "", kAfterASurfaceStop, [&](size_t group) {
    for (size_t i = group; i < photos.size(); i += kGroups) {
      ThrowIfStopRequested(kAfterASurfaceStop);
      groups[group].Add(photos[i], colors);
    }
  });
  for (size_t group = 1; group < kGroups; ++group) groups[0].Add(groups[group]);
  return std::move(groups[0]).Result();
}

}  // namespace tetrec
