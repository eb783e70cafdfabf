// One function for each mode.
#include "view/paint.h"

#include "core/parallel.h"
#include "core/quantile.h"
#include "core/random.h"
#include "image/resize.h"
#include "mesh/locate.h"
#include "render/create_renderer.h"
#include "render/picture.h"
#include "render/target_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

// Pixels between two checks whether to give up; their rays take some 20 ms on two cores.
constexpr int kBandPixels = 30'000;
// An error of this much of the range of a channel is the brightest that the colours distinguish.
constexpr double kLargestError = 0.25;
constexpr glm::dvec3 kNothing(0.5);  // where there is no surface, tet or pixel that counts
// The share of a tet's volume by which rounding may put a point of a face beyond it. Without it, a
// point that two tets put beyond their common face would be in neither.
constexpr double kOnFace = 1e-9;
// Tets of which the nearest is where a walk begins; to look at them takes about 10 us.
constexpr size_t kFirstTets = 256;

// Calls body(camera of the band, first row) for bands of rows from top to bottom. False if given
// up.
template <class Body>
bool ForBands(const Camera& camera, const std::function<bool()>& give_up, const Body& body) {
  const int rows = std::max(1, kBandPixels / camera.width);
  for (int y = 0; y < camera.height; y += rows) {
    if (y > 0 && give_up()) return false;
    Camera band = camera;
    band.height = std::min(rows, camera.height - y);
    band.cy -= y;
    body(band, y);
  }
  return true;
}

// The picture whose rows are painted by row(image, y), several at a time. None if given up.
template <class Row>
std::optional<Image> PaintRows(const Camera& camera, const std::function<bool()>& give_up,
                               const Row& row) {
  Image image = MakeImage(camera.width, camera.height, 3);
  const bool is_done = ForBands(camera, give_up, [&](const Camera& band, int top) {
    ParallelFor(size_t(band.height), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) row(image, top + int(i));
    });
  });
  return is_done ? std::optional(std::move(image)) : std::nullopt;
}

void PutPixel(Image& image, int x, int y, const glm::dvec3& color) {
  for (int c = 0; c < 3; ++c) {
    image.At(x, y)[c] = uint8_t(std::lround(255 * std::clamp(color[c], 0.0, 1.0)));
  }
}

// Black, red, yellow, white for 0 to 1.
glm::dvec3 HeatColor(double heat) {
  return glm::clamp(glm::dvec3(3 * heat, 3 * heat - 1, 3 * heat - 2), 0.0, 1.0);
}

// The same number in [0, 1) for a tet each time, and another one for its neighbours.
double TintOf(uint32_t tet) { return double((tet * 2654435761u) >> 8) / double(1u << 24); }

double SizeOf(const TetMesh& mesh, uint32_t tet) {
  return std::cbrt(std::abs(TetVolume(mesh, mesh.tets[tet])));
}

// Before the background, which is not exposed.
void Expose(const PhotoExposure& exposure, RenderedImage& rendered) {
  for (size_t i = 0; i < rendered.color_srgb.size(); ++i) {
    const double opacity = 1 - double(rendered.transmittance[i]);
    rendered.color_srgb[i] =
        glm::vec3(exposure.gain * glm::dvec3(rendered.color_srgb[i]) + opacity * exposure.offset);
  }
}

std::optional<Image> PaintColor(ShownField& shown, Background background, const RenderView& from,
                                const PhotoExposure& exposure,
                                const std::function<bool()>& give_up) {
  Image image = MakeImage(from.camera.width, from.camera.height, 3);
  const bool is_done = ForBands(from.camera, give_up, [&](const Camera& band, int y) {
    RenderedImage rendered = shown.renderer->Render({band, from.cam_from_world}, 1);
    Expose(exposure, rendered);
    const Image part = ToPicture(rendered, background);
    std::copy(part.pixels.begin(), part.pixels.end(), image.At(0, y));
  });
  return is_done ? std::optional(std::move(image)) : std::nullopt;
}

std::optional<DepthMap> FindDepth(ShownField& shown, const RenderView& from,
                                  const std::function<bool()>& give_up) {
  DepthMap map = MakeDepthMap(from.camera.width, from.camera.height);
  const bool is_done = ForBands(from.camera, give_up, [&](const Camera& band, int y) {
    const DepthMap part = shown.renderer->RenderDepth({band, from.cam_from_world}, kHalfLightDepth);
    std::copy(part.depth.begin(), part.depth.end(), &map.At(0, y));
  });
  return is_done ? std::optional(std::move(map)) : std::nullopt;
}

// Searches for the tets of points, of which each is near the one before. Walks as FindTet does, but
// through a face drawn from those that the point is beyond: where tets are not Delaunay, above all
// where some are inside out, a walk without chance may circle (Devillers, Pion, Teillaud 2002,
// "Walking in a triangulation").
class TetFinder {
 public:
  explicit TetFinder(const TetMesh& mesh)
      : mesh_(mesh), most_steps_(100 + size_t(20 * std::cbrt(double(mesh.tets.size())))) {}

  // kNoTet outside of the mesh. Also at the end of a very long walk, which hardly happens unless
  // many tets are inside out: to try all tets, for many pixels, would take minutes.
  uint32_t At(const glm::dvec3& point) {
    uint32_t tet = last_ == kNoTet ? TetNear(point) : last_;
    for (size_t step = 0; step < most_steps_; ++step) {
      last_ = tet;
      const int face = FaceBeyond(tet, point);
      if (face < 0) return tet;
      tet = mesh_.neighbors[tet][face];
      if (tet == kNoTet) return kNoTet;  // the domain of a fitted field is convex
    }
    last_ = kNoTet;  // the next walk begins elsewhere
    return kNoTet;
  }

 private:
  // The tet whose first vertex is nearest to the point, of some all over the mesh.
  uint32_t TetNear(const glm::dvec3& point) const {
    const size_t stride = std::max<size_t>(1, mesh_.tets.size() / kFirstTets);
    uint32_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (size_t t = 0; t < mesh_.tets.size(); t += stride) {
      const glm::dvec3 way = glm::dvec3(mesh_.positions[mesh_.tets[t][0]]) - point;
      const double squared = glm::dot(way, way);
      if (squared >= least) continue;
      least = squared;
      nearest = uint32_t(t);
    }
    return nearest;
  }

  // One of the faces that the point is beyond, or -1 if the tet contains the point.
  int FaceBeyond(uint32_t tet, const glm::dvec3& point) {
    glm::dvec3 to[4];
    for (int i = 0; i < 4; ++i) to[i] = glm::dvec3(mesh_.positions[mesh_.tets[tet][i]]) - point;
    // Six times the signed volumes of the four tets that the point forms with the faces.
    const glm::dvec3 edge01 = glm::cross(to[0], to[1]), edge23 = glm::cross(to[2], to[3]);
    const double volumes[4] = {glm::dot(to[1], edge23), -glm::dot(to[0], edge23),
                               glm::dot(to[3], edge01), -glm::dot(to[2], edge01)};
    const double least = -kOnFace * std::abs(volumes[0] + volumes[1] + volumes[2] + volumes[3]);
    const int first = int(random_() >> 62);
    for (int i = first; i < first + 4; ++i) {
      if (volumes[i % 4] < least) return i % 4;
    }
    return -1;
  }

  const TetMesh& mesh_;
  const size_t most_steps_;
  SplitMix64 random_{0};    // the same for each row: pictures do not depend on the threads
  uint32_t last_ = kNoTet;  // where the last walk ended
};

// Large tets are blue, small ones yellow; neighbours differ in brightness.
std::optional<Image> PaintTets(const ShownField& shown, const RenderView& from,
                               const DepthMap& depth, const std::function<bool()>& give_up) {
  const TetMesh& mesh = shown.field.mesh;
  const Rigid3 world_from_cam = from.cam_from_world.Inverse();
  const double range = std::log(std::max(shown.large_tet / shown.small_tet, 1.01));
  return PaintRows(from.camera, give_up, [&](Image& image, int y) {
    TetFinder finder(mesh);
    for (int x = 0; x < image.width; ++x) {
      const double z = depth.At(x, y);
      const uint32_t tet =
          z == kNoDepth
              ? kNoTet
              : finder.At(world_from_cam * (z * from.camera.CamFromImage(glm::dvec2(x, y) + 0.5)));
      if (tet == kNoTet) {
        PutPixel(image, x, y, kNothing);
        continue;
      }
      const double coarseness = std::log(SizeOf(mesh, tet) / shown.small_tet) / range;
      const glm::dvec3 color = glm::mix(glm::dvec3(1, 0.86, 0.25), glm::dvec3(0.1, 0.25, 0.75),
                                        std::clamp(coarseness, 0.0, 1.0));
      PutPixel(image, x, y, (0.6 + 0.4 * TintOf(tet)) * color);
    }
  });
}

struct Sample {
  double density = 0;
  glm::dvec3 color_srgb{0};
};

Sample SampleAt(const RadianceField& field, uint32_t tet, const glm::dvec3& point) {
  if (field.storage == FieldStorage::kCell) {
    return {field.density[tet], glm::dvec3(field.color_srgb[tet])};
  }
  const glm::uvec4& ids = field.mesh.tets[tet];
  const glm::dvec4 weights = WeightsInTet(field.mesh, tet, point);
  Sample sample;
  for (int i = 0; i < 4; ++i) {
    sample.density += weights[i] * field.density[ids[i]];
    sample.color_srgb += weights[i] * glm::dvec3(field.color_srgb[ids[i]]);
  }
  sample.density = std::max(sample.density, 0.0);
  return sample;
}

// The field in a plane across the view: its colour, as opaque as a slab of a fiftieth of the
// subject's size is, over the tets in shades of grey.
std::optional<Image> PaintSlice(const ShownField& shown, const Scene& scene,
                                const PictureRequest& request,
                                const std::function<bool()>& give_up) {
  const RadianceField& field = shown.field;
  const glm::dvec3 size = scene.subject_bounds.Size();
  const double slab = 0.02 * std::max({size.x, size.y, size.z});
  const Camera& camera = request.from.camera;
  const Rigid3 world_from_cam = request.from.cam_from_world.Inverse();
  return PaintRows(camera, give_up, [&](Image& image, int y) {
    TetFinder finder(field.mesh);
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec3 point =
          world_from_cam * (request.slice_depth * camera.CamFromImage(glm::dvec2(x, y) + 0.5));
      const uint32_t tet = finder.At(point);
      if (tet == kNoTet) {
        PutPixel(image, x, y, kNothing);
        continue;
      }
      const Sample sample = SampleAt(field, tet, point);
      const double opacity = 1 - std::exp(-sample.density * slab);
      PutPixel(image, x, y,
               glm::mix(glm::dvec3(0.15 + 0.15 * TintOf(tet)), sample.color_srgb, opacity));
    }
  });
}

const View& ViewOf(const Scene& scene, const PictureRequest& request) {
  return scene.views[size_t(*request.view)];
}

// The stored image of the view, with its own alpha. None if given up.
std::optional<Image> PhotoOf(const ShownScene& scene, const PictureRequest& request,
                             const Camera& size, const std::function<bool()>& give_up) {
  const Image stored = ReadImage(scene.folder / ViewOf(scene.scene, request).image);
  if (give_up()) return std::nullopt;
  return ResizeSmoothly(stored, size.width, size.height);
}

std::optional<Image> PaintPhoto(const ShownScene& scene, const PictureRequest& request,
                                const std::function<bool()>& give_up) {
  const std::optional<Image> photo = PhotoOf(scene, request, request.from.camera, give_up);
  if (!photo) return std::nullopt;
  return TruthOf(*photo, scene.scene.has_masks, scene.scene.background);
}

// What the photo shows of the field; neutral for photos whose exposure was not estimated.
PhotoExposure ExposureOf(const ShownField& shown, const std::string& photo) {
  const auto found =
      std::find_if(shown.exposures.begin(), shown.exposures.end(),
                   [&](const PhotoExposure& exposure) { return exposure.name == photo; });
  return found == shown.exposures.end() ? PhotoExposure{} : *found;
}

// The mean absolute difference over the channels, of images of the camera's size.
std::optional<Image> PaintDifference(const Image& photo, const Image& rendered, const Scene& scene,
                                     const Camera& camera, const std::function<bool()>& give_up) {
  const Image truth = TruthOf(photo, scene.has_masks, scene.background);
  return PaintRows(camera, give_up, [&](Image& image, int y) {
    for (int x = 0; x < image.width; ++x) {
      if (scene.has_masks && photo.channels == 4 && photo.At(x, y)[3] < kSeenAlpha) {
        PutPixel(image, x, y, kNothing);
        continue;
      }
      double sum = 0;
      for (int c = 0; c < 3; ++c) sum += std::abs(truth.At(x, y)[c] - rendered.At(x, y)[c]);
      PutPixel(image, x, y, HeatColor(sum / (3 * 255) / kLargestError));
    }
  });
}

// The camera of the request, or the photo's own if the request asks for more pixels than the photo
// has.
Camera ComparingCamera(const Scene& scene, const PictureRequest& request) {
  const Camera& own = scene.cameras[size_t(ViewOf(scene, request).camera)];
  return request.from.camera.width > own.width ? own : request.from.camera;
}

std::optional<Image> PaintError(ShownField& shown, const ShownScene& scene,
                                const PictureRequest& request,
                                const std::function<bool()>& give_up) {
  const Camera camera = ComparingCamera(scene.scene, request);
  const std::optional<Image> rendered =
      PaintColor(shown, scene.scene.background, {camera, request.from.cam_from_world},
                 ExposureOf(shown, ViewOf(scene.scene, request).name), give_up);
  if (!rendered) return std::nullopt;
  const std::optional<Image> photo = PhotoOf(scene, request, camera, give_up);
  if (!photo) return std::nullopt;
  const std::optional<Image> error =
      PaintDifference(*photo, *rendered, scene.scene, camera, give_up);
  if (!error || give_up()) return std::nullopt;
  return ResizeSmoothly(*error, request.from.camera.width, request.from.camera.height);
}

}  // namespace

ShownField MakeShownField(FieldContent content, RendererOptions options) {
  RadianceField& field = content.field;
  if (CountDegenerateTets(field.mesh) > 0) options.AcceptInvertedTets();
  ShownField shown;
  shown.renderer = CreateRenderer(options);
  shown.renderer->SetField(field);
  std::vector<double> sizes(field.mesh.tets.size());
  for (uint32_t i = 0; i < sizes.size(); ++i) sizes[i] = SizeOf(field.mesh, i);
  if (!sizes.empty()) {
    shown.small_tet = std::max(Quantile(sizes, 0.02), 1e-12);
    shown.large_tet = Quantile(std::move(sizes), 0.98);
  }
  shown.field = std::move(field);
  shown.exposures = std::move(content.exposures);
  return shown;
}

std::optional<Image> Paint(ShownField& shown, const ShownScene& scene,
                           const PictureRequest& request, const std::function<bool()>& give_up) {
  const RenderView& from = request.from;
  const Background background = scene.scene.background;
  switch (request.mode) {
    case PictureMode::kColor:
      return PaintColor(shown, background, from, {}, give_up);
    case PictureMode::kSlice:
      return PaintSlice(shown, scene.scene, request, give_up);
    case PictureMode::kPhoto:
      return PaintPhoto(scene, request, give_up);
    case PictureMode::kError:
      return PaintError(shown, scene, request, give_up);
    case PictureMode::kDepth:
    case PictureMode::kNormals:
    case PictureMode::kTets:
      break;
  }
  const std::optional<DepthMap> depth = FindDepth(shown, from, give_up);
  if (!depth) return std::nullopt;
  if (request.mode == PictureMode::kDepth) return ColoredDepth(*depth, RangeOf(*depth));
  if (request.mode == PictureMode::kNormals) return NormalPicture(*depth, from.camera);
  return PaintTets(shown, from, *depth, give_up);
}

}  // namespace tetrec
