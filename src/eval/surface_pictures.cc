// The surface drawn over the photos' cameras.
#include "eval/surface_pictures.h"

#include "core/parallel.h"
#include "eval/find_view.h"
#include "image/psnr.h"
#include "mesh/seen_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {
using nlohmann::json;

constexpr int kRaysPerSide = 2;

// Bilinear between texels' centres; coordinates as TriangleMesh has them.
glm::dvec3 TextureColor(const Image& texture, const glm::dvec2& coordinates) {
  const double x = std::clamp(coordinates.x * texture.width - 0.5, 0.0, texture.width - 1.0),
               y = std::clamp((1 - coordinates.y) * texture.height - 0.5, 0.0,
                              texture.height - 1.0);
  const int x0 = int(x), y0 = int(y);
  const auto at = [&](int i, int j) {
    const uint8_t* rgb =
        texture.At(std::min(x0 + i, texture.width - 1), std::min(y0 + j, texture.height - 1));
    return glm::dvec3(rgb[0], rgb[1], rgb[2]);
  };
  return glm::mix(glm::mix(at(0, 0), at(1, 0), x - x0), glm::mix(at(0, 1), at(1, 1), x - x0),
                  y - y0);
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

Camera Finer(const Camera& camera) {
  return {camera.width * kRaysPerSide, camera.height * kRaysPerSide, camera.fx * kRaysPerSide,
          camera.fy * kRaysPerSide,    camera.cx * kRaysPerSide,     camera.cy * kRaysPerSide};
}

// The pixels of both, as a mask of MaskedMeanSquaredError.
Image MaskOf(const SurfacePicture& picture, const std::optional<Image>& seen) {
  Image mask = MakeImage(picture.image.width, picture.image.height, 3);
  for (size_t i = 0; i < picture.covered.size(); ++i) {
    const bool counts = !seen || seen->pixels[i * size_t(seen->channels)] >= kSelectedByMask;
    if (picture.covered[i] && counts) std::fill_n(&mask.pixels[3 * i], 3, uint8_t{255});
  }
  return mask;
}

// Nothing if the view shows nothing of the surface.
std::optional<SurfaceViewScore> ScoreView(const TriangleMesh& mesh, const Image& texture,
                                          const Camera& camera, const View& view,
                                          const RenderedView& rendered) {
  const Image truth = ReadImage(rendered.truth), render = ReadImage(rendered.render);
  CheckSameSize(render, truth, "ground truth");
  // The scene may have been imported again at another size.
  if (truth.width != camera.width || truth.height != camera.height) return std::nullopt;
  const SurfacePicture picture = DrawSurface(mesh, texture, camera, view.cam_from_world);
  const Image mask =
      MaskOf(picture, rendered.seen ? std::optional(ReadImage(*rendered.seen)) : std::nullopt);
  const auto error = MaskedMeanSquaredError(picture.image, truth, mask);
  if (!error) return std::nullopt;
  SurfaceViewScore score{view.name, CappedPsnrFromMse(*error), 0, 0, 0};
  score.vertex_color_psnr = score.psnr;
  if (!texture.pixels.empty() && !mesh.colors_srgb.empty()) {
    const SurfacePicture plain = DrawSurface(mesh, {}, camera, view.cam_from_world);
    score.vertex_color_psnr = CappedPsnrFromMse(*MaskedMeanSquaredError(plain.image, truth, mask));
  }
  score.field_psnr = CappedPsnrFromMse(*MaskedMeanSquaredError(render, truth, mask));
  score.covered = double(std::count(picture.covered.begin(), picture.covered.end(), true)) /
                  double(picture.covered.size());
  return score;
}

}  // namespace

SurfacePicture DrawSurface(const TriangleMesh& mesh, const Image& texture, const Camera& camera,
                           const Rigid3& cam_from_world) {
  const Camera finer = Finer(camera);
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

std::optional<SurfacePictures> ScoreSurfacePictures(const TriangleMesh& mesh, const Image& texture,
                                                    const Scene& scene,
                                                    const RenderedViews& rendered) {
  if (texture.pixels.empty() && mesh.colors_srgb.empty()) return std::nullopt;
  std::vector<std::optional<SurfaceViewScore>> scores(rendered.views.size());
  ParallelForEach(scores.size(), "", "the run will be evaluated again", [&](size_t i) {
    const View* view = FindView(scene, rendered.views[i].name);
    if (view == nullptr) return;
    scores[i] =
        ScoreView(mesh, texture, scene.cameras[size_t(view->camera)], *view, rendered.views[i]);
  });
  SurfacePictures pictures{!texture.pixels.empty(), {}, {}};
  for (size_t i = 0; i < scores.size(); ++i) {
    if (scores[i]) {
      pictures.views.push_back(*scores[i]);
    } else {
      pictures.views_without_surface.push_back(rendered.views[i].name);
    }
  }
  return pictures;
}

json SurfacePicturesJson(const SurfacePictures& pictures) {
  const std::pair<const char*, double SurfaceViewScore::*> kNumbers[] = {
      {"psnr", &SurfaceViewScore::psnr},
      {"vertex_color_psnr", &SurfaceViewScore::vertex_color_psnr},
      {"field_psnr", &SurfaceViewScore::field_psnr},
      {"covered", &SurfaceViewScore::covered}};
  json result = {{"textured", pictures.textured},
                 {"views", json::array()},
                 {"views_without_surface", pictures.views_without_surface}};
  for (const SurfaceViewScore& view : pictures.views) {
    json row = {{"name", view.name}};
    for (const auto& [name, number] : kNumbers) row[name] = view.*number;
    result["views"].push_back(row);
  }
  for (const auto& [name, number] : kNumbers) {
    double sum = 0;
    for (const SurfaceViewScore& view : pictures.views) sum += view.*number;
    result[name] = pictures.views.empty() ? json() : json(sum / double(pictures.views.size()));
  }
  return result;
}

}  // namespace tetrec
