// Fewer training views, judged by the same held-out views.
#include "sfm/thin_views.h"

#include "core/error.h"
#include "expect_error.h"
#include "scene/split.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

// Views 00 to 49; point i is seen by views i and i + 1, and point 100 by all.
ColmapModel ModelOfNeighbours() {
  ColmapModel model;
  for (uint32_t i = 0; i < 50; ++i) model.images[i].name = fmt::format("{:02}.jpg", i);
  for (uint32_t i = 0; i < 49; ++i) model.points[i].track = {{i, 0}, {i + 1, 0}};
  for (uint32_t i = 0; i < 50; ++i) model.points[100].track.push_back({i, 0});
  return model;
}

Scene SceneOf(const ColmapModel& model) {
  Scene scene;
  for (const auto& [id, image] : model.images) {
    scene.views.emplace_back();
    scene.views.back().name = image.name;
  }
  HoldOut(scene.views, kUsualHoldout);
  for (const auto& [id, point] : model.points) {
    scene.points.emplace_back();
    scene.points.back().track_length = uint32_t(point.track.size());
  }
  return scene;
}

TEST(ThinTrainingViews, KeepsEveryFourthForTrainingAndAllThatAreHeldOut) {
  const ColmapModel model = ModelOfNeighbours();
  Scene scene = SceneOf(model);
  const size_t held_out = scene.HeldOutViews().size();
  EXPECT_EQ(ThinTrainingViews(model, 4, scene), 50 - 13 - held_out);
  EXPECT_EQ(scene.HeldOutViews().size(), held_out);
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  ASSERT_EQ(training.size(), 13u);
  for (size_t i = 0; i < training.size(); ++i) {
    EXPECT_EQ(scene.views[size_t(training[i])].name, fmt::format("{:02}.jpg", 1 + 4 * i));
  }
}

TEST(ThinTrainingViews, KeepsThePointsThatTwoOfTheKeptTrainingViewsSee) {
  const ColmapModel model = ModelOfNeighbours();
  Scene scene = SceneOf(model);
  ThinTrainingViews(model, 4, scene);
  // No two neighbours are kept; the point that all views see is seen by the 13.
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].track_length, 13u);
}

TEST(ThinTrainingViews, RefusesToLeaveASingleTrainingView) {
  const ColmapModel model = ModelOfNeighbours();
  Scene scene = SceneOf(model);
  ExpectError<DataError>([&] { ThinTrainingViews(model, 50, scene); }, {"50", "leaves 1"});
}

}  // namespace
}  // namespace tetrec
