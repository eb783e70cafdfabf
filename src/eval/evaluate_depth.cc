// The depth's part of the evaluation.
#include "eval/evaluate_depth.h"

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/quantile.h"
#include "eval/find_view.h"
#include "eval/metrics_json.h"
#include "eval/true_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

DepthMap ReadRendered(const JudgedView& view) {
  DepthMap map = ReadDepthMap(view.depth);
  if (map.width != view.camera->width || map.height != view.camera->height) {
    throw DataError(fmt::format("{}: is {}x{} px, but the view's camera {}x{}; render it again",
                                view.depth.string(), map.width, map.height, view.camera->width,
                                view.camera->height));
  }
  return map;
}

DepthErrors ErrorsByMaps(const std::vector<JudgedView>& views, const std::filesystem::path& folder,
                         double world_from_input_scale) {
  DepthErrors errors;
  for (const JudgedView& view : views) {
    errors.Add(ReadRendered(view),
               ReadNerfDepth(folder, view.view->name, *view.camera, world_from_input_scale));
  }
  return errors;
}

DepthErrors ErrorsByMesh(const std::vector<JudgedView>& views,
                         const std::filesystem::path& mesh_file,
                         const Similarity3& truth_from_world, const Bounds3& bounds_in_truth,
                         std::vector<std::string>& warnings) {
  const TriangleMesh mesh = ReadTriangleMesh(mesh_file);
  DepthErrors errors;
  size_t cut = 0;
  for (const JudgedView& view : views) {
    const MeshDepth depth = DepthOfMesh(mesh, truth_from_world, bounds_in_truth, *view.camera,
                                        view.view->cam_from_world);
    errors.Add(ReadRendered(view), depth.map);
    cut += depth.cut_triangles;
  }
  if (cut > 0) {
    Warn(warnings, fmt::format("{} triangles of the true mesh reach behind a camera and are left "
                               "out of its true depth",
                               cut));
  }
  return errors;
}

}  // namespace

void DepthErrors::Add(const DepthMap& rendered, const DepthMap& truth) {
  if (rendered.depth.size() != truth.depth.size()) {
    throw DataError("a rendered depth map and its truth differ in size");
  }
  const size_t before = errors_.size();
  for (size_t pixel = 0; pixel < truth.depth.size(); ++pixel) {
    const float want = truth.depth[pixel], got = rendered.depth[pixel];
    if (want == kNoDepth) continue;
    missing_ += got == kNoDepth;
    errors_.push_back(got == kNoDepth ? std::numeric_limits<double>::infinity()
                                      : std::abs(double(got) - double(want)));
  }
  views_ += errors_.size() > before;
}

std::optional<DepthScores> DepthErrors::Score(double diagonal) && {
  const size_t pixels = errors_.size();
  if (pixels == 0) return std::nullopt;
  const auto near = std::count_if(errors_.begin(), errors_.end(),
                                  [&](double error) { return error <= kNear * diagonal; });
  DepthScores scores;
  scores.diagonal = diagonal;
  scores.views = views_;
  scores.pixels = pixels;
  scores.missing = missing_;
  scores.share_within_1_percent = double(near) / double(pixels);
  scores.median = ValueOfRank(std::move(errors_), pixels / 2);
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
  std::optional<DepthScores> scores;
  if (has_maps) {
    scores = ErrorsByMaps(views, stage.Input("depth-maps"), 1 / scene->input_from_world.scale)
                 .Score(glm::length(scene->subject_bounds.Size()));
    if (scores) scores->truth = "the data set's depth maps";
  } else {
    Similarity3 truth_from_world = scene->input_from_world;
    if (surface->alignment) {
      truth_from_world = surface->alignment->truth_from_input * truth_from_world;
    }
    scores = ErrorsByMesh(views, stage.Input("ground-truth"), truth_from_world,
                          surface->scores->crop, warnings)
                 .Score(surface->scores->diagonal / truth_from_world.scale);
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
