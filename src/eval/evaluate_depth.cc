// The depth's part of the evaluation.
#include "eval/evaluate_depth.h"

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "eval/find_view.h"
#include "eval/metrics_json.h"
#include "eval/true_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

constexpr double kNear = 0.01;  // share of the diagonal within which a depth counts as found

// A view whose depth was rendered, with its place in the scene.
struct JudgedView {
  const View* view;
  const Camera* camera;
  std::filesystem::path depth;
};

std::vector<JudgedView> JudgedViews(const RenderedViews& rendered, const Scene& scene) {
  std::vector<JudgedView> judged;
  for (const RenderedView& entry : rendered.views) {
    const View* view = FindView(scene, entry.name);
    if (view == nullptr || !entry.depth) continue;
    judged.push_back({view, &scene.cameras[size_t(view->camera)], *entry.depth});
  }
  return judged;
}

std::vector<DepthMap> ReadMaps(const std::vector<JudgedView>& views) {
  std::vector<DepthMap> maps;
  for (const JudgedView& view : views) {
    maps.push_back(ReadDepthMap(view.depth));
    if (maps.back().width == view.camera->width && maps.back().height == view.camera->height) {
      continue;
    }
    throw DataError(fmt::format("{}: is {}x{} px, but the view's camera {}x{}; render it again",
                                view.depth.string(), maps.back().width, maps.back().height,
                                view.camera->width, view.camera->height));
  }
  return maps;
}

std::vector<DepthMap> MapsOfMesh(const std::vector<JudgedView>& views,
                                 const std::filesystem::path& mesh_file,
                                 const Similarity3& truth_from_world,
                                 const Bounds3& bounds_in_truth,
                                 std::vector<std::string>& warnings) {
  const TriangleMesh mesh = ReadTriangleMesh(mesh_file);
  std::vector<DepthMap> maps;
  size_t cut = 0;
  for (const JudgedView& view : views) {
    MeshDepth depth = DepthOfMesh(mesh, truth_from_world, bounds_in_truth, *view.camera,
                                  view.view->cam_from_world);
    maps.push_back(std::move(depth.map));
    cut += depth.cut_triangles;
  }
  if (cut > 0) {
    Warn(warnings, fmt::format("{} triangles of the true mesh reach behind a camera and are left "
                               "out of its true depth",
                               cut));
  }
  return maps;
}

}  // namespace

std::optional<DepthScores> ScoreDepths(std::span<const DepthMap> rendered,
                                       std::span<const DepthMap> truth, double diagonal) {
  TETREC_CHECK(rendered.size() == truth.size(), "one true depth map per view");
  DepthScores scores;
  scores.diagonal = diagonal;
  std::vector<double> errors;
  for (size_t i = 0; i < truth.size(); ++i) {
    const size_t before = errors.size();
    if (rendered[i].depth.size() != truth[i].depth.size()) {
      throw DataError("a rendered depth map and its truth differ in size");
    }
    for (size_t pixel = 0; pixel < truth[i].depth.size(); ++pixel) {
      const float want = truth[i].depth[pixel], got = rendered[i].depth[pixel];
      if (want == kNoDepth) continue;
      scores.missing += got == kNoDepth;
      errors.push_back(got == kNoDepth ? std::numeric_limits<double>::infinity()
                                       : std::abs(double(got) - double(want)));
    }
    scores.views += errors.size() > before;
  }
  if (errors.empty()) return std::nullopt;
  scores.pixels = errors.size();
  const auto near = std::count_if(errors.begin(), errors.end(),
                                  [&](double error) { return error <= kNear * diagonal; });
  scores.share_within_1_percent = double(near) / double(errors.size());
  const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  scores.median = *middle;
  return scores;
}

std::optional<DepthScores> EvaluateDepth(const RenderedViews& rendered,
                                         const std::optional<Scene>& scene,
                                         const std::optional<SurfaceResult>& surface,
                                         const Stage& stage, std::vector<std::string>& warnings) {
  const bool has_mesh = stage.HasInput("ground-truth") && surface && surface->scores;
  const bool has_maps = stage.HasInput("depth-maps");
  if (!scene || !(has_mesh || has_maps)) return std::nullopt;
  const std::vector<JudgedView> views = JudgedViews(rendered, *scene);
  if (views.empty()) {
    Warn(warnings,
         "the views were rendered without depth maps, which are not judged; render them again");
    return std::nullopt;
  }
  const std::vector<DepthMap> maps = ReadMaps(views);
  std::optional<DepthScores> scores;
  if (has_maps) {
    std::vector<DepthMap> truth;
    for (const JudgedView& view : views) {
      truth.push_back(ReadNerfDepth(stage.Input("depth-maps"), view.view->name, *view.camera,
                                    1 / scene->input_from_world.scale));
    }
    scores = ScoreDepths(maps, truth, glm::length(scene->subject_bounds.Size()));
    if (scores) scores->truth = "the data set's depth maps";
  } else {
    Similarity3 truth_from_world = scene->input_from_world;
    if (surface->alignment) {
      truth_from_world = surface->alignment->truth_from_input * truth_from_world;
    }
    const std::vector<DepthMap> truth = MapsOfMesh(
        views, stage.Input("ground-truth"), truth_from_world, surface->scores->crop, warnings);
    scores = ScoreDepths(maps, truth, surface->scores->diagonal / truth_from_world.scale);
    if (scores) scores->truth = "the true mesh inside the scored box";
  }
  if (!scores) {
    Warn(warnings, "no view shows the true surface, so that no depth is judged");
    return scores;
  }
  LogInfo(
      "depth: median error {:.3f} % of the subject's diagonal over {} pixels of {} views, {} of "
      "them without a rendered surface",
      100 * scores->median / scores->diagonal, WithThousands(scores->pixels), scores->views,
      WithThousands(scores->missing));
  return scores;
}

nlohmann::json DepthJson(const DepthScores& scores) {
  return {{"median_error_percent_of_diagonal", Finite(100 * scores.median / scores.diagonal)},
          {"share_within_1_percent", scores.share_within_1_percent},
          {"diagonal", scores.diagonal},
          {"views", scores.views},
          {"pixels", scores.pixels},
          {"pixels_without_surface", scores.missing},
          {"truth", scores.truth}};
}

}  // namespace tetrec
