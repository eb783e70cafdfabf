// Pictures of a surface, their errors, and the errors' derivatives.
#include "surface/photo_differences.h"

#include "core/parallel.h"
#include "core/stop_request.h"
#include "mesh/seen_triangles.h"
#include "surface/local_means.h"
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

struct Pixel {
  glm::vec4 color{0.0f};  // RGBA, multiplied by alpha
  uint8_t hits = 0;       // rays of the pixel that meet the surface
  bool open = false;      // shows the surface's back, or a triangle at its border
  // The shares of the triangle's vertices in the point that each ray meets.
  std::array<glm::vec3, kRaysPerPixel> shares{};

  bool IsFilled() const { return hits == kRaysPerPixel; }
};

bool ShowsBack(const TriangleMesh& mesh, const glm::uvec3& triangle, const glm::dvec3& eye) {
  return glm::dot(DoubleAreaNormal(mesh, triangle), glm::dvec3(mesh.positions[triangle.x]) - eye) >
         0;
}

// A picture of the surface, of which the last three rows are kept.
class Picture {
 public:
  // All must outlive this. `copy` is null, or becomes the picture.
  Picture(const TriangleMesh& mesh, const std::vector<bool>& border, const SurfaceColors& color_at,
          const TexturePhoto& photo, SurfacePicture* copy)
      : mesh_(mesh),
        border_(border),
        color_at_(color_at),
        photo_(photo),
        rays_(WithRaysAsPixels(photo.camera)),
        eye_(photo.cam_from_world.Inverse().translation),
        seen_(FindSeenTriangles(mesh, rays_, photo.cam_from_world)),
        copy_(copy) {
    in_cam_.reserve(mesh.positions.size());
    for (const glm::vec3& position : mesh.positions) {
      in_cam_.push_back(photo.cam_from_world * glm::dvec3(position));
    }
    if (copy == nullptr) return;
    copy->image = MakeImage(photo.camera.width, photo.camera.height, 3);
    copy->covered.assign(size_t(photo.camera.width) * size_t(photo.camera.height), false);
  }

  Pixel Draw(int x, int y) const {
    Pixel pixel;
    ForEachHit(x, y, [&](int ray, size_t index) {
      const uint32_t triangle = seen_.triangle[index];
      const glm::vec3 shares = SharesAt(triangle, x, y, ray);
      pixel.shares[size_t(ray)] = shares;
      pixel.color += kShareOfRay * glm::vec4(color_at_(triangle, shares), 1.0f);
      ++pixel.hits;
      const glm::uvec3& t = mesh_.triangles[triangle];
      pixel.open =
          pixel.open || border_[t.x] || border_[t.y] || border_[t.z] || ShowsBack(mesh_, t, eye_);
    });
    return pixel;
  }

  void DrawRow(int y) {
    std::vector<Pixel>& row = rows_[size_t(y) % rows_.size()];
    row.clear();
    for (int x = 0; x < photo_.camera.width; ++x) {
      row.push_back(Draw(x, y));
      if (copy_ != nullptr) Copy(row.back(), x, y);
    }
  }

  // The pixel must be in one of the three rows that were drawn last.
  const Pixel& At(int x, int y) const { return rows_[size_t(y) % rows_.size()][size_t(x)]; }

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
    const glm::uvec3& t = mesh_.triangles[triangle];
    const glm::dvec3 shares = glm::max(CornerWeights({in_cam_[t.x], in_cam_[t.y], in_cam_[t.z]},
                                                     rays_, glm::dvec2(PlaceOf(x, y, ray)) + 0.5),
                                       0.0);
    const double sum = shares.x + shares.y + shares.z;
    return sum > 0 ? glm::vec3(shares / sum) : glm::vec3(1.0f / 3);
  }

  void Copy(const Pixel& pixel, int x, int y) {
    copy_->covered[photo_.Index(x, y)] = pixel.IsFilled();
    if (pixel.hits > 0) SetColor(copy_->image, x, y, glm::vec3(pixel.color) / pixel.color.a);
  }

  const TriangleMesh& mesh_;
  const std::vector<bool>& border_;
  const SurfaceColors& color_at_;
  const TexturePhoto& photo_;
  Camera rays_;  // whose pixels are the rays
  glm::dvec3 eye_;
  SeenTriangles seen_;
  SurfacePicture* copy_;
  std::vector<glm::dvec3> in_cam_;  // the vertices
  std::array<std::vector<Pixel>, 3> rows_;
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

  // `copy` is null, or becomes what is drawn.
  void Add(const TexturePhoto& photo, const SurfaceColors& color_at, SurfacePicture* copy) {
    Picture picture(mesh_, border_, color_at, photo, copy);
    const LocalMeans slow = SlowErrors(photo, picture);
    for (int below = 0; below < photo.camera.height; ++below) {
      picture.DrawRow(below);
      const int y = below - 1;
      if (y < 1) continue;
      for (int x = 1; x + 1 < photo.camera.width; ++x) {
        if (Compares(photo, picture, x, y)) AddPixel(photo, picture, slow, x, y);
      }
    }
  }

  void Add(const Differences& other) {
    for (size_t v = 0; v < vertices_.size(); ++v) vertices_[v] += other.vertices_[v];
    squared_error_ += other.squared_error_;
    squared_local_error_ += other.squared_local_error_;
    values_ += other.values_;
  }

  PhotoDifferences Result() && {
    if (!(values_ > 0)) return {std::move(vertices_), 0, 0};
    return {std::move(vertices_), squared_error_ / values_, squared_local_error_ / values_};
  }

 private:
  // A quarter of the pixels is enough.
  static LocalMeans SlowErrors(const TexturePhoto& photo, const Picture& picture) {
    LocalMeans slow(photo.camera.width, photo.camera.height);
    for (int y = 0; y < photo.camera.height; y += 2) {
      for (int x = 0; x < photo.camera.width; x += 2) {
        const Pixel pixel = picture.Draw(x, y);
        if (pixel.open || !ShowsNothingElse(photo, pixel, x, y)) continue;
        slow.Add(x, y, glm::vec3(ErrorOf(pixel, photo, x, y)));
      }
    }
    slow.Smooth();
    return slow;
  }

  static bool NextToOpen(const Picture& picture, int x, int y) {
    for (int row = y - 1; row <= y + 1; ++row) {
      for (int column = x - 1; column <= x + 1; ++column) {
        if (picture.At(column, row).open) return true;
      }
    }
    return false;
  }

  static bool Compares(const TexturePhoto& photo, const Picture& picture, int x, int y) {
    if (NextToOpen(picture, x, y)) return false;
    if (photo.alpha_is_opacity) {
      return picture.At(x, y).hits > 0 || photo.image.At(x, y)[3] > 0;
    }
    return photo.Counts(x, y) && picture.At(x, y).IsFilled() && picture.At(x - 1, y).IsFilled() &&
           picture.At(x + 1, y).IsFilled() && picture.At(x, y - 1).IsFilled() &&
           picture.At(x, y + 1).IsFilled();
  }

  static float AlphaOf(const TexturePhoto& photo, int x, int y) {
    return photo.alpha_is_opacity ? float(photo.image.At(x, y)[3]) / 255.0f : 1.0f;
  }

  static bool ShowsNothingElse(const TexturePhoto& photo, const Pixel& pixel, int x, int y) {
    return photo.Counts(x, y) && pixel.IsFilled();
  }

  static glm::vec4 ErrorOf(const Pixel& pixel, const TexturePhoto& photo, int x, int y) {
    const float alpha = AlphaOf(photo, x, y);
    return glm::vec4(alpha * glm::vec3(photo.ColorOf(x, y)), alpha) - pixel.color;
  }

  void AddPixel(const TexturePhoto& photo, const Picture& picture, const LocalMeans& slow, int x,
                int y) {
    const Pixel& pixel = picture.At(x, y);
    const glm::vec4 whole_error = ErrorOf(pixel, photo, x, y);
    const glm::vec4 error = whole_error - AlphaOf(photo, x, y) * glm::vec4(slow.At(x, y), 0.0f);
    squared_error_ += double(glm::dot(whole_error, whole_error));
    squared_local_error_ += double(glm::dot(error, error));
    values_ += photo.alpha_is_opacity ? 4 : 3;

    VertexDifferences still{.seen = 1};
    if (ShowsNothingElse(photo, pixel, x, y)) {
      still.color_error = glm::vec3(whole_error), still.color_weight = 1;
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
      const glm::vec4 along_x = 0.5f * (picture.At(x + 1, y).color - picture.At(x - 1, y).color);
      const glm::vec4 along_y = 0.5f * (picture.At(x, y + 1).color - picture.At(x, y - 1).color);
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
      const glm::vec3 shares = kShareOfRay * pixel.shares[size_t(ray)];
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
  double squared_error_ = 0, squared_local_error_ = 0, values_ = 0;  // values: channels of pixels
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
                                   const SurfaceColors& color_at,
                                   std::span<const TexturePhoto> photos,
                                   std::span<SurfacePicture> pictures) {
  std::vector<Differences> groups(kGroups, Differences(mesh, border));
  ParallelForEach(kGroups, "", kAfterASurfaceStop, [&](size_t group) {
    for (size_t i = group; i < photos.size(); i += kGroups) {
      ThrowIfStopRequested(kAfterASurfaceStop);
      groups[group].Add(photos[i], color_at, pictures.empty() ? nullptr : &pictures[i]);
    }
  });
  for (size_t group = 1; group < kGroups; ++group) groups[0].Add(groups[group]);
  return std::move(groups[0]).Result();
}

}  // namespace tetrec
