// The surface drawn over the photos, and its error.
#include "eval/surface_pictures.h"

#include "core/parallel.h"
#include "eval/find_view.h"
#include "image/psnr.h"
#include "surface/draw_surface.h"

#include <algorithm>

namespace tetrec {
namespace {
using nlohmann::json;

// A mask of the view's pixels that count.
Image CountingPixels(const RenderedView& rendered, const Image& truth) {
  if (rendered.seen) return ReadImage(*rendered.seen);
  Image all = MakeImage(truth.width, truth.height, 3);
  std::ranges::fill(all.pixels, uint8_t{255});
  return all;
}

// Those of them that the surface fills, as a mask of MaskedMeanSquaredError.
Image MaskOf(const SurfacePicture& picture, const Image& counting) {
  Image mask = MakeImage(picture.image.width, picture.image.height, 3);
  for (size_t i = 0; i < picture.covered.size(); ++i) {
    const bool counts = counting.pixels[i * size_t(counting.channels)] >= kSelectedByMask;
    if (picture.covered[i] && counts) std::fill_n(&mask.pixels[3 * i], 3, uint8_t{255});
  }
  return mask;
}

size_t SelectedPixels(const Image& mask) {
  size_t selected = 0;
  for (size_t i = 0; i < mask.pixels.size(); i += size_t(mask.channels)) {
    selected += mask.pixels[i] >= kSelectedByMask;
  }
  return selected;
}

// Nothing if the view shows nothing of the surface.
std::optional<SurfaceViewScore> ScoreView(const TriangleMesh& mesh, const Image& texture,
                                          const Camera& camera, const View& view,
                                          const RenderedView& rendered) {
  const Image truth = ReadImage(rendered.truth), render = ReadImage(rendered.render);
  CheckSameSize(render, truth, "ground truth");
  // The scene may have been imported again at another size.
  if (truth.width != camera.width || truth.height != camera.height) return std::nullopt;
  const auto draw = [&](const Image& colors) {
    return DrawSurface(mesh, colors, camera, view.cam_from_world, kJudgingRaysPerSide);
  };
  const SurfacePicture picture = draw(texture);
  const Image counting = CountingPixels(rendered, truth), mask = MaskOf(picture, counting);
  const auto error = MaskedMeanSquaredError(picture.image, truth, mask);
  if (!error) return std::nullopt;
  SurfaceViewScore score{view.name, CappedPsnrFromMse(*error), 0, 0, 0};
  score.vertex_color_psnr = score.psnr;
  if (!texture.pixels.empty() && !mesh.colors_srgb.empty()) {
    const SurfacePicture plain = draw({});
    score.vertex_color_psnr = CappedPsnrFromMse(*MaskedMeanSquaredError(plain.image, truth, mask));
  }
  score.field_psnr = CappedPsnrFromMse(*MaskedMeanSquaredError(render, truth, mask));
  score.covered = double(SelectedPixels(mask)) / double(SelectedPixels(counting));
  return score;
}

}  // namespace

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
