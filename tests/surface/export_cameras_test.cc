// Cameras and points for other programs.
#include "surface/export_cameras.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tetrec {
namespace {

// One camera that stands at (1, 2, 3) and looks along y, with z up, and another one behind it.
ExportedScene TwoViews(Split second = Split::kTest) {
  const glm::dmat3 cam_from_world = glm::transpose(glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0}));
  ExportedScene scene;
  scene.folder = "/run/1_scene";
  scene.cameras = {{64, 48, 50, 51, 32, 24}};
  for (const double y : {2.0, 1.0}) {
    View view;
    view.name = fmt::format("a {}", y);
    view.image = fmt::format("images/sub/a {}.png", y);
    view.cam_from_world = {cam_from_world, -(cam_from_world * glm::dvec3(1, y, 3))};
    scene.views.push_back(view);
  }
  scene.views[1].split = second;
  scene.points = {{{0.5, 0.25, -1}, {1, 2, 3}, 0.5f, 4}};
  return scene;
}

TEST(ExportCameras, PosesHaveOpenGlAxes) {
  const nlohmann::json transforms = TransformsOf(TwoViews(), "/run/5_surface");
  const nlohmann::json& frame = transforms["frames"][0];
  EXPECT_EQ(frame["file_path"], "../1_scene/images/sub/a 2.png");
  EXPECT_EQ(frame["w"], 64);
  EXPECT_EQ(frame["fl_y"], 51.0);
  // x right, y up, z back.
  const std::vector<std::vector<double>> expected = {
      {1, 0, 0, 1}, {0, 0, -1, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}};
  EXPECT_EQ(frame["transform_matrix"].get<std::vector<std::vector<double>>>(), expected);
}

TEST(ExportCameras, HeldOutViewsAreForValidationAndTestWhereThereIsOneSplit) {
  for (const Split split : {Split::kTest, Split::kValidation}) {
    const nlohmann::json transforms = TransformsOf(TwoViews(split), "/run/5_surface");
    const std::vector<std::string> first = {"../1_scene/images/sub/a 2.png"},
                                   second = {"../1_scene/images/sub/a 1.png"};
    EXPECT_EQ(transforms["train_filenames"], first);
    EXPECT_EQ(transforms["val_filenames"], second);
    EXPECT_EQ(transforms["test_filenames"], second);
  }
  EXPECT_FALSE(TransformsOf(TwoViews(Split::kTrain), "/run").contains("train_filenames"));
}

TEST(ExportCameras, AColmapModelNamesImagesWithoutTheirFolder) {
  const ExportedScene scene = TwoViews();
  const ColmapModel model = ColmapModelOf(scene);
  ASSERT_EQ(model.images.size(), 2u);
  EXPECT_EQ(model.images.at(1).name, "sub/a 2.png");
  EXPECT_EQ(model.images.at(2).cam_from_world.translation,
            scene.views[1].cam_from_world.translation);
  EXPECT_EQ(model.cameras.at(model.images.at(2).camera).params,
            (std::vector<double>{50, 51, 32, 24}));
  ASSERT_EQ(model.points.size(), 1u);
  EXPECT_EQ(model.points.at(1).position, scene.points[0].position);
  EXPECT_EQ(model.points.at(1).error_px, 0.5);
}

}  // namespace
}  // namespace tetrec
