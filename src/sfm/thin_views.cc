// Fewer training views, to measure how few photos suffice.
#include "sfm/thin_views.h"

#include "core/error.h"

#include <fmt/format.h>

#include <set>
#include <string>

namespace tetrec {
namespace {

bool IsKept(const View& view, size_t place, int every) {
  return view.split != Split::kTrain || place % size_t(every) == 1;
}

// The number of different views in `names` that see the point.
uint32_t ViewsThatSee(const ColmapPoint& point, const ColmapModel& model,
                      const std::set<std::string>& names) {
  std::set<uint32_t> images;
  for (const ColmapTrackItem& item : point.track) {
    if (names.contains(model.images.at(item.image).name)) images.insert(item.image);
  }
  return uint32_t(images.size());
}

}  // namespace

size_t ThinTrainingViews(const ColmapModel& model, int every, Scene& scene) {
  TETREC_CHECK(scene.points.size() == model.points.size(),
               fmt::format("{} points of {}", scene.points.size(), model.points.size()));
  std::vector<View> kept;
  std::set<std::string> training;
  for (size_t i = 0; i < scene.views.size(); ++i) {
    if (!IsKept(scene.views[i], i, every)) continue;
    if (scene.views[i].split == Split::kTrain) training.insert(scene.views[i].name);
    kept.push_back(scene.views[i]);
  }
  if (training.size() < 2) {
    throw DataError(
        fmt::format("of {} views, every {}-th leaves {} to train on; at least 2 are needed",
                    scene.views.size(), every, training.size()));
  }
  std::vector<ScenePoint> points;
  size_t index = 0;
  for (const auto& [id, point] : model.points) {
    ScenePoint& of_scene = scene.points[index++];
    of_scene.track_length = ViewsThatSee(point, model, training);
    if (of_scene.track_length >= 2) points.push_back(of_scene);
  }
  const size_t dropped = scene.views.size() - kept.size();
  scene.views = std::move(kept);
  scene.points = std::move(points);
  return dropped;
}

}  // namespace tetrec
