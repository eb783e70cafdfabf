#include "scene/import.h"

#include "core/error.h"
#include "expect_error.h"
#include "scene/image.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>

namespace tetrec {
namespace {

using Json = nlohmann::json;

// Where the synthetic scene lies in the data set's own coordinates.
const Similarity3 kInputFromSynthetic{2.5, glm::dmat3(1.0), {1, -2, 0.5}};

SyntheticScene SomeScene(SyntheticKind kind = SyntheticKind::kBall) {
  SyntheticOptions options;
  options.kind = kind;
  options.train_views = 24;
  options.validation_views = 3;
  options.test_views = 2;
  options.width = 80;
  options.height = 60;
  options.rays_per_side = 2;
  return MakeSyntheticScene(options);
}

// World from camera in the data set's coordinates, OpenGL axes, four rows.
Json Pose(const Rigid3& cam_from_synthetic) {
  const Rigid3 synthetic_from_cam = cam_from_synthetic.Inverse();
  const glm::dvec3 place = kInputFromSynthetic * synthetic_from_cam.translation;
  const glm::dmat3& axes = synthetic_from_cam.rotation;
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({axes[0][i], -axes[1][i], -axes[2][i], place[i]});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

// Writes the scene as a NeRF-synthetic folder.
void WriteNerf(const ScratchFolder& folder, const SyntheticScene& synthetic) {
  const Camera& camera = synthetic.scene.cameras[0];
  const std::pair<Split, const char*> splits[] = {
      {Split::kTrain, "train"}, {Split::kValidation, "val"}, {Split::kTest, "test"}};
  for (const auto& [split, name] : splits) {
    Json json = {{"camera_angle_x", 2 * std::atan(0.5 * camera.width / camera.fx)},
                 {"frames", Json::array()}};
    const std::vector<int> views = synthetic.scene.ViewsOf(split);
    for (size_t i = 0; i < views.size(); ++i) {
      const std::string file = std::string(name) + "/r_" + std::to_string(i);
      std::filesystem::create_directories(folder / name);
      WriteImage(folder / (file + ".png"), synthetic.images[size_t(views[i])]);
      const Rigid3& pose = synthetic.scene.views[size_t(views[i])].cam_from_world;
      json["frames"].push_back({{"file_path", "./" + file}, {"transform_matrix", Pose(pose)}});
    }
    folder.Write("transforms_" + std::string(name) + ".json", json.dump());
  }
}

ImportOptions AtSize(int max_size) {
  ImportOptions options;
  options.max_size = max_size;
  return options;
}

TEST(Import, NormalisesTheWorldAndKeepsEveryPointAtItsPixel) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  WriteNerf(folder, synthetic);
  const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", AtSize(40));
  const Scene scene = ReadScene(folder / "scene");

  EXPECT_EQ(imported.resized, 29u);
  EXPECT_EQ(scene.background, Background::kWhite);
  EXPECT_TRUE(scene.has_alpha);
  EXPECT_EQ(scene.ViewsOf(Split::kTrain).size(), 24u);
  EXPECT_EQ(scene.ViewsOf(Split::kValidation).size(), 3u);
  EXPECT_EQ(scene.ViewsOf(Split::kTest).size(), 2u);

  const glm::dvec3 size = scene.subject_bounds.Size();
  EXPECT_NEAR(std::max({size.x, size.y, size.z}), 2.0, 1e-12);
  EXPECT_LT(glm::length(scene.subject_bounds.Center()), 1e-12);

  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].width, 40);
  EXPECT_EQ(scene.cameras[0].height, 30);
  const Similarity3 world_from_synthetic = scene.input_from_world.Inverse() * kInputFromSynthetic;
  for (size_t i = 0; i < scene.views.size(); ++i) {
    for (const glm::dvec3& point : {glm::dvec3(0.0), glm::dvec3(0.5, -0.3, 0.8)}) {
      const glm::dvec2 before =
          synthetic.scene.cameras[0].ImageFromCam(synthetic.scene.views[i].cam_from_world * point);
      const glm::dvec2 after = scene.cameras[0].ImageFromCam(scene.views[i].cam_from_world *
                                                             (world_from_synthetic * point));
      EXPECT_LT(glm::length(after - 0.5 * before), 1e-9) << scene.views[i].name;
    }
  }
  // The ball (radius 0.9) is inside of the bounds, in our world's units.
  const glm::dvec3 center = world_from_synthetic * glm::dvec3(0.0);
  const double radius = 0.9 * world_from_synthetic.scale;
  EXPECT_TRUE(scene.subject_bounds.Contains(center + radius));
  EXPECT_TRUE(scene.subject_bounds.Contains(center - radius));
  EXPECT_GT(radius, 0.8);
}

TEST(Import, StoresTheAreaMeanOfEachPicture) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  WriteNerf(folder, synthetic);
  ImportDataset(folder.path(), folder / "scene", AtSize(40));
  const Scene scene = ReadScene(folder / "scene");
  for (size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(ReadImage(folder / "scene" / scene.views[i].image).pixels,
              ResizeByArea(synthetic.images[i], 40, 30).pixels);
  }
}

TEST(Import, KeepsPicturesThatAreSmallEnough) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  WriteNerf(folder, synthetic);
  for (const int max_size : {0, 80, 500}) {
    const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", AtSize(max_size));
    EXPECT_EQ(imported.resized, 0u);
    EXPECT_EQ(imported.scene.cameras[0].width, 80);
    EXPECT_NEAR(imported.scene.cameras[0].fx, synthetic.scene.cameras[0].fx, 1e-9);
  }
}

TEST(Import, WithoutAlphaTakesWhatAllCamerasSee) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene(SyntheticKind::kRoom));
  std::filesystem::remove(folder / "transforms_val.json");
  const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", AtSize(40));
  EXPECT_FALSE(imported.scene.has_alpha);
  EXPECT_EQ(imported.missing_files, std::vector<std::string>{"transforms_val.json"});
  EXPECT_LT(
      glm::length(imported.scene.input_from_world.translation - kInputFromSynthetic.translation),
      1e-9);
}

TEST(Import, RefusesACutPictureAndPicturesThatDiffer) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene());
  std::filesystem::resize_file(folder / "test/r_1.png", 500);
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(40)); },
                         {"test/r_1.png", "truncated"});
  WriteImage(folder / "test/r_1.png", MakeImage(80, 60, 3));
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(40)); },
                         {"test/r_1.png", "no alpha"});
}

TEST(Import, RefusesOptionsThatMakeNoSense) {
  ImportOptions options;
  options.max_size = -1;
  ExpectError<UsageError>([&] { options.Check(); }, {"--max-size -1"});
  options = {};
  options.holdout = 1;
  ExpectError<UsageError>([&] { options.Check(); }, {"--holdout 1"});
}

TEST(FitToMaxSize, KeepsTheShape) {
  EXPECT_EQ(FitToMaxSize(800, 600, 200), glm::ivec2(200, 150));
  EXPECT_EQ(FitToMaxSize(600, 800, 200), glm::ivec2(150, 200));
  EXPECT_EQ(FitToMaxSize(1000, 333, 100), glm::ivec2(100, 33));
  EXPECT_EQ(FitToMaxSize(5000, 1, 100), glm::ivec2(100, 1));
  EXPECT_EQ(FitToMaxSize(64, 48, 64), glm::ivec2(64, 48));
}

TEST(Import, FindsTheBoundsOfLego) {
  const char* datasets = std::getenv("TETREC_DATASETS");
  const std::filesystem::path lego =
      std::filesystem::path(datasets ? datasets : TETREC_SOURCE_DIR "/../shared/datasets") / "lego";
  if (!std::filesystem::exists(lego))
    GTEST_SKIP() << "no data set at " << lego << " (TETREC_DATASETS)";
  const ScratchFolder folder;
  const Scene scene = ImportDataset(lego, folder.path(), AtSize(100)).scene;
  EXPECT_EQ(scene.ViewsOf(Split::kTest).size(), 25u);  // three files a view lie in its folder
  const glm::dvec3 min = scene.input_from_world * scene.subject_bounds.min;
  const glm::dvec3 max = scene.input_from_world * scene.subject_bounds.max;
  // The model's extent to a few hundredths; no view looks from below, where the hull sags by 0.1.
  const Bounds3 model{{-0.63, -1.14, -0.48}, {0.63, 1.14, 1.0}};
  EXPECT_TRUE(glm::all(glm::lessThan(min, model.min)) &&
              glm::all(glm::greaterThan(max, model.max)));
  EXPECT_LT(glm::length(min - model.min), 0.3);
  EXPECT_LT(glm::length(max - model.max), 0.25);
}

}  // namespace
}  // namespace tetrec
