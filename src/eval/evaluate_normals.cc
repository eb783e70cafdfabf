// The normals' part of the evaluation.
#include "eval/evaluate_normals.h"

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/quantile.h"
#include "eval/find_view.h"
#include "eval/metrics_json.h"
#include "eval/true_normals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace tetrec {
namespace {

double AngleDeg(const glm::vec3& a, const glm::vec3& b) {
  const double cosine = glm::dot(glm::dvec3(a), glm::dvec3(b));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

void NormalAngles::Add(const NormalMap& rendered, const NormalMap& truth) {
  if (rendered.width != truth.width || rendered.height != truth.height) {
    throw DataError("a rendered normal map and its truth differ in size; render it again");
  }
  constexpr glm::vec3 kNone(0.0f);
  const size_t before = angles_deg_.size();
  for (size_t pixel = 0; pixel < truth.normal.size(); ++pixel) {
    const glm::vec3 &want = truth.normal[pixel], &got = rendered.normal[pixel];
    if (want == kNone) continue;
    if (got == kNone) {
      ++missing_;
    } else {
      angles_deg_.push_back(AngleDeg(got, want));
    }
  }
  views_ += angles_deg_.size() > before;
}

std::optional<NormalScores> NormalAngles::Score() && {
  const size_t pixels = angles_deg_.size();
  if (pixels == 0) return std::nullopt;
  const double sum = std::accumulate(angles_deg_.begin(), angles_deg_.end(), 0.0);
  return NormalScores{.views = views_,
                      .pixels = pixels,
                      .missing = missing_,
                      .mean_angle_deg = sum / double(pixels),
                      .median_angle_deg = ValueOfRank(std::move(angles_deg_), pixels / 2)};
}

std::optional<NormalScores> EvaluateNormals(const RenderedViews& rendered,
                                            const std::optional<Scene>& scene, const Stage& stage,
                                            std::vector<std::string>& warnings) {
  if (!scene || !stage.HasInput("depth-maps")) return std::nullopt;
  const glm::dmat3& input_from_world = scene->input_from_world.rotation;
  NormalAngles angles;
  bool has_maps = false;
  for (const RenderedView& entry : rendered.views) {
    const View* view = FindView(*scene, entry.name);
    if (view == nullptr || !entry.normals) continue;
    const Camera& camera = scene->cameras[size_t(view->camera)];
    const glm::dmat3 input_from_cam =
        input_from_world * glm::transpose(view->cam_from_world.rotation);
    NormalMap truth;
    try {
      truth = ReadNerfNormals(stage.Input("depth-maps"), view->name, camera, input_from_cam);
    } catch (const DataError& error) {
      Warn(warnings, fmt::format("normals are not judged: {}", error.what()));
      return std::nullopt;
    }
    angles.Add(Rotated(input_from_world, ReadNormalMap(*entry.normals)), truth);
    has_maps = true;
  }
  if (!has_maps) {
    Warn(warnings,
         "the views were rendered without normal maps, which are not judged; render "
         "them again");
    return std::nullopt;
  }
  const std::optional<NormalScores> scores = std::move(angles).Score();
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
