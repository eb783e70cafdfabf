// The normals' part of the evaluation.
#include "eval/evaluate_normals.h"

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "eval/find_view.h"
#include "eval/metrics_json.h"
#include "eval/true_normals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace tetrec {
namespace {

double AngleDeg(const glm::vec3& a, const glm::vec3& b) {
  const double cosine = glm::dot(glm::dvec3(a), glm::dvec3(b));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

std::optional<NormalScores> ScoreNormals(std::span<const NormalMap> rendered,
                                         std::span<const NormalMap> truth) {
  TETREC_CHECK(rendered.size() == truth.size(), "one true normal map per view");
  constexpr glm::vec3 kNone(0.0f);
  NormalScores scores;
  std::vector<double> angles;
  for (size_t i = 0; i < truth.size(); ++i) {
    const size_t before = angles.size();
    if (rendered[i].width != truth[i].width || rendered[i].height != truth[i].height) {
      throw DataError("a rendered normal map and its truth differ in size; render it again");
    }
    for (size_t pixel = 0; pixel < truth[i].normal.size(); ++pixel) {
      const glm::vec3 &want = truth[i].normal[pixel], &got = rendered[i].normal[pixel];
      if (want == kNone) continue;
      if (got == kNone) {
        ++scores.missing;
      } else {
        angles.push_back(AngleDeg(got, want));
      }
    }
    scores.views += angles.size() > before;
  }
  if (angles.empty()) return std::nullopt;
  scores.pixels = angles.size();
  scores.mean_angle_deg =
      std::accumulate(angles.begin(), angles.end(), 0.0) / double(angles.size());
  const auto middle = angles.begin() + std::ptrdiff_t(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  scores.median_angle_deg = *middle;
  return scores;
}

std::optional<NormalScores> EvaluateNormals(const RenderedViews& rendered,
                                            const std::optional<Scene>& scene, const Stage& stage,
                                            std::vector<std::string>& warnings) {
  if (!scene || !stage.HasInput("depth-maps")) return std::nullopt;
  const glm::dmat3& input_from_world = scene->input_from_world.rotation;
  std::vector<NormalMap> maps, truth;
  for (const RenderedView& entry : rendered.views) {
    const View* view = FindView(*scene, entry.name);
    if (view == nullptr || !entry.normals) continue;
    const Camera& camera = scene->cameras[size_t(view->camera)];
    const glm::dmat3 input_from_cam =
        input_from_world * glm::transpose(view->cam_from_world.rotation);
    try {
      truth.push_back(
          ReadNerfNormals(stage.Input("depth-maps"), view->name, camera, input_from_cam));
    } catch (const DataError& error) {
      Warn(warnings, fmt::format("normals are not judged: {}", error.what()));
      return std::nullopt;
    }
    maps.push_back(Rotated(input_from_world, ReadNormalMap(*entry.normals)));
  }
  if (maps.empty()) {
    Warn(warnings,
         "the views were rendered without normal maps, which are not judged; render "
         "them again");
    return std::nullopt;
  }
  const std::optional<NormalScores> scores = ScoreNormals(maps, truth);
  if (!scores) {
    Warn(warnings, "no view shows a true normal, so that no normals are judged");
    return scores;
  }
  LogInfo(
      "normals: mean angle {:.1f} degrees, median {:.1f}, over {} pixels of {} views; {} have "
      "no rendered surface",
      scores->mean_angle_deg, scores->median_angle_deg, WithThousands(scores->pixels),
      scores->views, WithThousands(scores->missing));
  return scores;
}

nlohmann::json NormalsJson(const NormalScores& scores) {
  return {{"mean_angle_deg", scores.mean_angle_deg},
          {"median_angle_deg", scores.median_angle_deg},
          {"views", scores.views},
          {"pixels", scores.pixels},
          {"pixels_without_surface", scores.missing},
          {"truth", "the data set's normal maps"}};
}

}  // namespace tetrec
