#include "import/import.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "image/image.h"
#include "import/stored_pictures.h"
#include "paths.h"
#include "scene/points.h"
#include "scene/subject_bounds.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tetrec {
namespace {

using Json = nlohmann::json;

// The place of the synthetic scene in the data set's coordinates.
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

// World from camera in the data set's coordinates, with OpenGL axes, as four rows.
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
  // The ball (radius 0.9) is inside the bounds, in the scene's world units.
  const glm::dvec3 center = world_from_synthetic * glm::dvec3(0.0);
  const double radius = 0.9 * world_from_synthetic.scale;
  EXPECT_TRUE(scene.subject_bounds.Contains(center + radius));
  EXPECT_TRUE(scene.subject_bounds.Contains(center - radius));
  EXPECT_GT(radius, 0.8);
}

TEST(Import, StoresTheAreaMeanOfEachImage) {
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

TEST(Import, KeepsImagesThatAreSmallEnough) {
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

TEST(Import, RefusesATruncatedImageAndImagesThatDiffer) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene());
  std::filesystem::resize_file(folder / "test/r_1.png", 500);
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(40)); },
                         {"test/r_1.png", "truncated"});
  WriteImage(folder / "test/r_1.png", MakeImage(80, 60, 3));
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(40)); },
                         {"test/r_1.png", "no alpha"});
}

TEST(Import, ReadsColourProfilesAndNamesThoseThatAreDamaged) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene());
  std::vector<uint8_t> png = ReadBytes(folder / "train/r_1.png");
  const std::string_view chunk("\0\0\0\x05iCCPx\0\0??\0\0\0\0", 17);
  constexpr ptrdiff_t kBehindHeader = 33;
  png.insert(png.begin() + kBehindHeader, chunk.begin(), chunk.end());
  WriteBytes(folder / "train/r_1.png", png);
  ::testing::internal::CaptureStderr();
  ImportDataset(folder.path(), folder / "scene", AtSize(40));
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              ::testing::HasSubstr(
                  "images whose colour profile is damaged, or not one of RGB primaries and curves, "
                  "read as sRGB: 1 (train/r_1)"));
}

// Writes the scene as one transforms.json with the lens in pixels.
Json WriteTransforms(const ScratchFolder& folder, const SyntheticScene& synthetic) {
  const Camera& camera = synthetic.scene.cameras[0];
  Json json = {{"w", camera.width},      {"h", camera.height}, {"fl_x", camera.fx},
               {"fl_y", camera.fy},      {"cx", camera.cx},    {"cy", camera.cy},
               {"frames", Json::array()}};
  std::filesystem::create_directories(folder / "images");
  for (size_t i = 0; i < synthetic.images.size(); ++i) {
    const std::string file = fmt::format("images/{:02}", i);
    WriteImage(folder / (file + ".png"), synthetic.images[i]);
    json["frames"].push_back({{"file_path", file + ".png"},
                              {"transform_matrix", Pose(synthetic.scene.views[i].cam_from_world)}});
  }
  folder.Write("transforms.json", json.dump());
  return json;
}

// The names of the test views of the imported scene.
std::vector<std::string> TestViews(const Scene& scene) {
  std::vector<std::string> names;
  for (const int view : scene.ViewsOf(Split::kTest)) {
    names.push_back(scene.views[size_t(view)].name);
  }
  return names;
}

TEST(Import, ReadsTransformsAndHoldsOutEveryEighth) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  WriteTransforms(folder, synthetic);
  const Scene scene = ImportDataset(folder.path(), folder / "scene", AtSize(40)).scene;
  EXPECT_EQ(TestViews(scene),
            (std::vector<std::string>{"images/00", "images/08", "images/16", "images/24"}));
  const Similarity3 world_from_synthetic = scene.input_from_world.Inverse() * kInputFromSynthetic;
  const glm::dvec3 point(0.5, -0.3, 0.8);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const glm::dvec2 before =
        synthetic.scene.cameras[0].ImageFromCam(synthetic.scene.views[i].cam_from_world * point);
    const glm::dvec2 after = scene.cameras[0].ImageFromCam(scene.views[i].cam_from_world *
                                                           (world_from_synthetic * point));
    EXPECT_LT(glm::length(after - 0.5 * before), 1e-9) << scene.views[i].name;
  }
}

TEST(Import, SplitsByHoldoutOrListInPlaceOfTheDataSetsOwn) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene());
  ImportOptions options = AtSize(10);
  const auto import = [&] {
    return TestViews(ImportDataset(folder.path(), folder / "scene", options).scene);
  };
  EXPECT_EQ(import(), (std::vector<std::string>{"test/r_0", "test/r_1"}));
  options.holdout = 10;  // of test/r_0, test/r_1, train/r_0, r_1, r_10 .. r_19, r_2 ...
  EXPECT_EQ(import(), (std::vector<std::string>{"test/r_0", "train/r_16", "train/r_4"}));
  options.holdout = 0;
  EXPECT_TRUE(import().empty());
  options.test_list = folder.Write("list.txt", "train/r_3\r\n\nr_20.png\ntest/r_1.png  ");
  EXPECT_EQ(import(), (std::vector<std::string>{"train/r_3", "train/r_20", "test/r_1"}));

  folder.Write("list.txt", "train/r_3\ntrain/r_99\n");
  ExpectError<DataError>([&] { import(); },
                         {"list.txt: line 2: no image", "\"train/r_99\"", "\"train/r_0\""});
  folder.Write("list.txt", "r_0\n");
  ExpectError<DataError>([&] { import(); }, {"line 1: \"r_0\" is the name of 3 images"});
  options.test_list = folder.Write("empty.txt", "\n \n");
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", options); },
                         {"empty.txt", "names no view", "holdout to 0"});
  options.test_list = folder / "none.txt";
  ExpectError<DataError>([&] { import(); }, {"none.txt"});
}

TEST(Import, RefusesToHoldOutAll) {
  const ScratchFolder folder;
  Json json = WriteTransforms(folder, SomeScene());
  json["frames"].erase(json["frames"].begin() + 1, json["frames"].end());
  folder.Write("transforms.json", json.dump());
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(10)); },
                         {"all 1 images are held out"});
}

TEST(Import, DownscalesByAFactor) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  WriteTransforms(folder, synthetic);
  ImportOptions options;
  options.downscale = 4;
  const Scene scene = ImportDataset(folder.path(), folder / "scene", options).scene;
  EXPECT_EQ(scene.cameras[0].width, 20);
  EXPECT_EQ(scene.cameras[0].height, 15);
  EXPECT_EQ(ReadImage(folder / "scene" / scene.views[3].image).pixels,
            ResizeByArea(synthetic.images[3], 20, 15).pixels);
}

TEST(Import, MakesAlphaOfMasks) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene();
  Json json = WriteTransforms(folder, synthetic);
  std::filesystem::create_directories(folder / "masks");
  for (size_t i = 0; i < synthetic.images.size(); ++i) {
    const Image& rgba = synthetic.images[i];
    Image mask = MakeImage(rgba.width, rgba.height, 3), rgb = mask;
    for (size_t p = 0; p < rgba.pixels.size() / 4; ++p) {
      std::copy_n(&rgba.pixels[4 * p], 3, &rgb.pixels[3 * p]);
      std::fill_n(&mask.pixels[3 * p], 3, rgba.pixels[4 * p + 3]);
    }
    const std::string name = fmt::format("masks/{:02}.png", i);
    WriteImage(folder / name, mask);
    WriteImage(folder / fmt::format("images/{:02}.png", i), rgb);
    json["frames"][i]["mask_path"] = name;
  }
  folder.Write("transforms.json", json.dump());
  ImportOptions options = AtSize(40);
  const auto import = [&] { return ImportDataset(folder.path(), folder / "scene", options); };
  const auto picture = [&](const Scene& scene) {
    return ReadImage(folder / "scene" / scene.views[5].image);
  };
  options.masks = MaskUse::kSubject;
  const Scene scene = import().scene;
  EXPECT_TRUE(scene.has_alpha);
  EXPECT_FALSE(scene.has_masks);
  EXPECT_EQ(scene.background, Background::kWhite);
  EXPECT_EQ(picture(scene).pixels, ResizeByArea(synthetic.images[5], 40, 30).pixels);

  options.masks = MaskUse::kIgnore;
  const ImportedScene ignoring = import();
  EXPECT_FALSE(ignoring.scene.has_alpha);
  EXPECT_TRUE(ignoring.scene.has_masks);
  EXPECT_GT(ignoring.masked_share, 0.1);
  EXPECT_LT(ignoring.masked_share, 0.9);
  EXPECT_EQ(ignoring.scene.background, Background::kScene);
  EXPECT_EQ(picture(ignoring.scene).pixels, picture(scene).pixels);
  EXPECT_TRUE(ReadScene(folder / "scene").has_masks);

  options.masks = MaskUse::kNone;
  const Scene without = import().scene;
  EXPECT_FALSE(without.has_alpha || without.has_masks);
  EXPECT_EQ(picture(without).channels, 3);

  json["frames"][4].erase("mask_path");
  folder.Write("transforms.json", json.dump());
  EXPECT_FALSE(import().scene.has_masks);
  options.masks = MaskUse::kIgnore;
  ExpectError<DataError>(import, {"1 of 29 images have no mask: images/04; give each one"});
  // With alpha and a mask that excludes pixels, it is unclear which of them counts.
  json["frames"][4]["mask_path"] = "masks/04.png";
  folder.Write("transforms.json", json.dump());
  WriteImage(folder / "images/04.png", synthetic.images[4]);
  ExpectError<DataError>(import, {"images/04.png has alpha and the mask", "masks mean: subject"});
  options.masks = MaskUse::kSubject;
  WriteImage(folder / "masks/04.png", MakeImage(80, 58, 3));
  ExpectError<DataError>(import, {"masks/04.png: mask of 80 x 58", "images/04.png of 80 x 60"});
  for (nlohmann::json& frame : json["frames"]) frame.erase("mask_path");
  folder.Write("transforms.json", json.dump());
  ExpectError<DataError>(import, {"masks: subject needs masks, but the data set has none"});
}

// Masks that leave nothing and alpha that is 0 everywhere are an error in all images and a warning
// in some.
TEST(Import, ReportsImagesThatShowNothing) {
  const ScratchFolder data, out;
  const SyntheticScene synthetic = SomeScene();
  WriteNerf(data, synthetic);
  const Image clear = MakeImage(80, 60, 4);
  WriteImage(data / "train/r_3.png", clear);
  ImportDataset(data.path(), out.path(), AtSize(80));
  for (int i = 0; i < 24; ++i) WriteImage(data / fmt::format("train/r_{}.png", i), clear);
  ExpectError<DataError>([&] { ImportDataset(data.path(), out.path(), AtSize(80)); },
                         {"in all 24 training images alpha is 0 everywhere"});

  Json json = Json::parse(ReadText(data / "transforms_train.json"));
  for (auto& frame : json["frames"]) frame["mask_path"] = "mask.png";
  data.Write("transforms.json", json.dump());
  std::filesystem::remove(data / "transforms_train.json");
  for (int i = 0; i < 24; ++i) {
    WriteImage(data / fmt::format("train/r_{}.png", i), MakeImage(80, 60, 3));
  }
  const auto import = [&](MaskUse use) {
    ImportOptions options = AtSize(80);
    options.masks = use;
    ImportDataset(data.path(), out.path(), options);
  };
  ExpectError<DataError>([&] { import(MaskUse::kIgnore); },
                         {"24 masks", "are missing: ", "mask.png", "set masks to none"});
  import(MaskUse::kNone);
  WriteImage(data / "mask.png", MakeImage(80, 60, 3));
  ExpectError<DataError>([&] { import(MaskUse::kIgnore); },
                         {"in all 21 training images masks leave no pixel", "set masks to none"});
  ExpectError<DataError>([&] { import(MaskUse::kSubject); }, {"alpha is 0 everywhere"});
}

TEST(Import, WarnsAboutBoundsAndPointsFarFromTheCameras) {
  const ScratchFolder data, out;
  WriteNerf(data, SomeScene());
  ImportOptions options = AtSize(80);
  options.bounds_in_input = Bounds3{{10000, 10000, 10000}, {10001, 10001, 10001}};
  TakeWarnings();
  ImportDataset(data.path(), out.path(), options);
  EXPECT_THAT(TakeWarnings(),
              testing::Contains(testing::HasSubstr("the middle of the given bounds at (10000.5")));
}

// The file of the training views may name points, with colours as numbers of 0 to 1. The points may
// be in another frame by mistake.
TEST(Import, ReadsPointsOfNerfSyntheticSetsAndRefusesThoseOfAnotherFrame) {
  const ScratchFolder data, out;
  WriteNerf(data, SomeScene());
  Json json = Json::parse(ReadText(data / "transforms_train.json"));
  json["ply_file_path"] = "points.ply";
  data.Write("transforms_train.json", json.dump());
  const auto write_points = [&](double x) {
    data.Write("points.ply",
               fmt::format("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty "
                           "float y\nproperty float z\nproperty float red\nproperty float "
                           "green\nproperty float blue\nend_header\n{0} -2 0.5 0.5 1 0\n{0} -2 "
                           "0.6 0 0 0.2\n",
                           x));
  };
  write_points(1);
  const ImportedScene imported = ImportDataset(data.path(), out.path(), AtSize(80));
  ASSERT_EQ(imported.scene.points.size(), 2u);
  EXPECT_EQ(imported.scene.points[0].color_srgb, (std::array<uint8_t, 3>{128, 255, 0}));
  EXPECT_EQ(imported.scene.points[1].color_srgb[2], 51);
  // Outside of what the cameras see, on both sides of the ring on which they are.
  data.Write("points.ply",
             "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
             "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
             "end_header\n1 -2 90000 1 2 3\n1 -2 -90000 1 2 3\n");
  ExpectError<DataError>([&] { ImportDataset(data.path(), out.path(), AtSize(80)); },
                         {"2 of 2 points are within no training image", "different frames"});
  // Triangulation, which the message advises, replaces them.
  ImportOptions options = AtSize(80);
  options.triangulate = true;
  const Dataset set = ReadForImport(data.path(), options);
  EXPECT_TRUE(set.points.empty());
  EXPECT_THAT(set.remarks, testing::ElementsAre(testing::HasSubstr("points.ply: points of the")));
}

// Later stages need held-out views to judge.
TEST(Import, HoldsOutEveryEighthOfSetsThatHoldOutNothing) {
  const ScratchFolder data, out;
  WriteNerf(data, SomeScene());
  std::filesystem::remove(data / "transforms_val.json");
  std::filesystem::remove(data / "transforms_test.json");
  EXPECT_EQ(ImportDataset(data.path(), out.path(), AtSize(80)).scene.ViewsOf(Split::kTest).size(),
            3u);
  ImportOptions none = AtSize(80);
  none.holdout = 0;
  EXPECT_EQ(ImportDataset(data.path(), out.path(), none).scene.ViewsOf(Split::kTest).size(), 0u);
}

TEST(Import, DropsAlphaThatHidesNothing) {
  const ScratchFolder folder;
  SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom);
  for (size_t i = 0; i < synthetic.images.size(); i += 2) {
    const Image& rgb = synthetic.images[i];
    Image rgba = MakeImage(rgb.width, rgb.height, 4);
    for (size_t p = 0; p < rgb.pixels.size() / 3; ++p) {
      std::copy_n(&rgb.pixels[3 * p], 3, &rgba.pixels[4 * p]);
      rgba.pixels[4 * p + 3] = 255;
    }
    synthetic.images[i] = rgba;
  }
  WriteTransforms(folder, synthetic);
  const auto import = [&] { return ImportDataset(folder.path(), folder / "scene", AtSize(80)); };
  const ImportedScene imported = import();
  EXPECT_EQ(imported.opaque, (synthetic.images.size() + 1) / 2);
  EXPECT_FALSE(imported.scene.has_alpha);
  EXPECT_EQ(imported.scene.background, Background::kScene);
  for (const View& view : imported.scene.views) {
    EXPECT_EQ(ReadImage(folder / "scene" / view.image).channels, 3);
  }
  // A single transparent pixel makes it count, and then all images must have alpha.
  synthetic.images[4].pixels[3] = 0;
  WriteTransforms(folder, synthetic);
  ExpectError<DataError>(import, {"images/01.png has no alpha channel or mask"});
}

TEST(Import, UsesTheGivenBox) {
  const ScratchFolder folder;
  Json json = WriteTransforms(folder, SomeScene(SyntheticKind::kRoom));
  ImportOptions options = AtSize(10);
  const auto import = [&] { return ImportDataset(folder.path(), folder / "scene", options).scene; };
  const auto place = [&] { return import().input_from_world; };
  // The box has side 1 / 0.5 around (0.5 - 0) / 0.5 and contains no camera.
  json.update({{"aabb_scale", 1}, {"scale", 0.5}, {"offset", 0}});
  folder.Write("transforms.json", json.dump());
  EXPECT_NEAR(place().scale, 1, 1e-12);
  EXPECT_LT(glm::length(place().translation - glm::dvec3(1, 1, 1)), 1e-12);
  // A box that contains the cameras does not bound the subject and is ignored.
  json["aabb_scale"] = 1000;
  folder.Write("transforms.json", json.dump());
  EXPECT_LT(glm::length(place().translation - kInputFromSynthetic.translation), 1e-9);

  // So is one where few cameras look, with a warning.
  json.update({{"aabb_scale", 1}, {"offset", -100}});
  folder.Write("transforms.json", json.dump());
  TakeWarnings();
  EXPECT_LT(glm::length(place().translation - kInputFromSynthetic.translation), 1e-9);
  EXPECT_THAT(
      TakeWarnings(),
      testing::Contains(testing::HasSubstr("only 2 of 25 training images show its centre")));

  options.bounds_in_input = {{0, 1, 2}, {1, 2, 6}};
  EXPECT_EQ(place().scale, 2);
  EXPECT_EQ(place().translation, glm::dvec3(0.5, 1.5, 4));
  const Bounds3 bounds = import().subject_bounds;
  EXPECT_LT(glm::length(bounds.max - glm::dvec3(0.25, 0.25, 1)), 1e-12);
}

// In the coordinates of COLMAP's models y often points down.
TEST(Import, StandsTheWorldUpright) {
  const ScratchFolder folder;
  Json json = WriteTransforms(folder, SomeScene());
  for (Json& frame : json["frames"]) {
    Json& rows = frame["transform_matrix"];
    Json z = rows[2];
    rows[2] = rows[1];
    for (Json& number : z) number = -number.get<double>();
    rows[1] = z;
  }
  folder.Write("transforms.json", json.dump());
  ImportOptions options = AtSize(10);
  options.bounds_in_input = {{0, -3, -4}, {1, 1, 0}};
  const Scene scene = ImportDataset(folder.path(), folder / "scene", options).scene;
  EXPECT_EQ(scene.input_from_world.rotation * glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0));
  EXPECT_NEAR(glm::determinant(scene.input_from_world.rotation), 1, 1e-12);
  EXPECT_GT(FindUp(scene.views).z, 0.9);
  EXPECT_EQ(scene.input_from_world * glm::dvec3(0.0), glm::dvec3(0.5, -1, -2));
  EXPECT_EQ(scene.subject_bounds.Size(), glm::dvec3(0.5, 2, 2));
}

// Turns the cameras, which look at the middle of a room, all in the same direction.
TEST(Import, UsesABoxAroundCamerasThatDoNotLookAtOnePlace) {
  const ScratchFolder folder;
  Json json = WriteTransforms(folder, SomeScene(SyntheticKind::kRoom));
  Bounds3 cameras;
  const Json parallel = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (size_t i = 0; i < json["frames"].size(); ++i) {
    Json& rows = json["frames"][i]["transform_matrix"];
    for (size_t row = 0; row < 3; ++row) {
      for (size_t k = 0; k < 3; ++k) rows[row][k] = parallel[row][k];
    }
    if (i % 8 > 0) {  // the others are held out
      cameras.Add({rows[0][3].get<double>(), rows[1][3].get<double>(), rows[2][3].get<double>()});
    }
  }
  folder.Write("transforms.json", json.dump());
  TakeWarnings();
  const Scene scene = ImportDataset(folder.path(), folder / "scene", AtSize(10)).scene;
  EXPECT_THAT(TakeWarnings(),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("a box around the cameras"),
                                                  testing::HasSubstr("give better bounds"),
                                                  testing::HasSubstr("triangulate points"))));
  const glm::dvec3 size = cameras.Size();
  const double longest = std::max({size.x, size.y, size.z});
  EXPECT_LT(glm::length(scene.input_from_world.translation - cameras.Center()), 1e-9);
  EXPECT_NEAR(scene.input_from_world.scale, 1.5 * longest, 1e-9);

  for (Json& frame : json["frames"]) {
    for (size_t row = 0; row < 3; ++row) frame["transform_matrix"][row][3] = 1;
  }
  folder.Write("transforms.json", json.dump());
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(10)); },
                         {"all at one place", "triangulation", "the subject's bounds"});
}

TEST(Import, LeavesMissingImagesOutOnRequest) {
  const ScratchFolder folder;
  WriteNerf(folder, SomeScene());
  std::filesystem::remove(folder / "train/r_3.png");
  std::filesystem::remove(folder / "test/r_1.png");
  ImportOptions options = AtSize(10);
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", options); },
                         {"2 of 29 images are missing", "train/r_3, test/r_1"});
  options.skip_missing = true;
  const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", options);
  EXPECT_EQ(imported.skipped, (std::vector<std::string>{"train/r_3", "test/r_1"}));
  EXPECT_EQ(imported.scene.ViewsOf(Split::kTrain).size(), 23u);
  EXPECT_EQ(TestViews(imported.scene), std::vector<std::string>{"test/r_0"});
}

TEST(Import, CountsTheViewsThatMaySeeNerfstudiosPoints) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom);
  Json json = WriteTransforms(folder, synthetic);
  std::vector<ScenePoint> points;
  for (int i = 0; i < 64; ++i) {
    const glm::dvec3 corner(i % 4, i / 4 % 4, i / 16);
    points.push_back({kInputFromSynthetic * (0.6 * (corner - 1.5)), {1, 2, 3}, 0, 0});
  }
  WriteScenePoints(folder / "points.ply", points);
  json["ply_file_path"] = "points.ply";
  folder.Write("transforms.json", json.dump());
  const Scene scene = ImportDataset(folder.path(), folder / "scene", AtSize(40)).scene;
  ASSERT_EQ(scene.points.size(), points.size());
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  size_t in_some_pictures = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 in_world = scene.input_from_world.Inverse() * points[i].position;
    EXPECT_LT(glm::length(scene.points[i].position - in_world), 1e-9);
    uint32_t expected = 0;
    for (const int v : training) {
      const View& view = scene.views[size_t(v)];
      const Camera& camera = scene.cameras[size_t(view.camera)];
      const glm::dvec3 in_cam = view.cam_from_world * in_world;
      const glm::dvec2 pixel = camera.ImageFromCam(in_cam);
      const bool inside = in_cam.z > 0 && std::abs(pixel.x / camera.width - 0.5) < 0.5 &&
                          std::abs(pixel.y / camera.height - 0.5) < 0.5;
      expected += inside ? 1 : 0;
    }
    EXPECT_EQ(scene.points[i].track_length, expected);
    in_some_pictures += expected > 0 && expected < training.size();
  }
  EXPECT_GT(in_some_pictures, 0u);
}

// Adds an EXIF orientation, a quarter turn, to a JPEG.
void AddQuarterTurn(const std::filesystem::path& jpeg) {
  const std::vector<uint8_t> app1 = {0xFF, 0xE1, 0, 34, 'E', 'x', 'i', 'f', 0,    0,    'I', 'I',
                                     42,   0,    8, 0,  0,   0,   1,   0,   0x12, 0x01, 3,   0,
                                     1,    0,    0, 0,  6,   0,   0,   0,   0,    0,    0,   0};
  std::vector<uint8_t> bytes = ReadBytes(jpeg);
  bytes.insert(bytes.begin() + 2, app1.begin(), app1.end());
  WriteBytes(jpeg, bytes);
}

TEST(Import, RotatesImagesByExifOnlyIfTheirCamerasAreRotated) {
  const ScratchFolder folder;
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom);
  Json json = WriteTransforms(folder, synthetic);
  for (size_t i = 0; i < synthetic.images.size(); ++i) {
    const std::string name = fmt::format("images/{:02}.jpg", i);
    WriteImage(folder / name, synthetic.images[i]);
    AddQuarterTurn(folder / name);
    json["frames"][i]["file_path"] = name;
  }
  folder.Write("transforms.json", json.dump());
  const ImportedScene as_stored = ImportDataset(folder.path(), folder / "scene", AtSize(80));
  EXPECT_EQ(as_stored.turned, 0u);
  EXPECT_EQ(as_stored.scene.cameras[0].width, 80);

  json.update({{"w", 60}, {"h", 80}, {"cx", 30}, {"cy", 40}});
  folder.Write("transforms.json", json.dump());
  const ImportedScene turned = ImportDataset(folder.path(), folder / "scene", AtSize(80));
  EXPECT_EQ(turned.turned, synthetic.images.size());
  EXPECT_EQ(turned.scene.cameras[0].width, 60);
  EXPECT_EQ(ReadImage(folder / "scene" / turned.scene.views[0].image).height, 80);

  json.update({{"w", 61}});
  folder.Write("transforms.json", json.dump());
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", AtSize(80)); },
                         {"has 80 x 60 pixels, its camera 61 x 80"});
}

TEST(Import, RefusesAFileInPlaceOfAFolder) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.Write("transforms.json", "{}");
  ExpectError<DataError>([&] { RecogniseDataset(file); },
                         {"transforms.json: is a file", "give the folder"});
}

TEST(Import, RefusesOptionsThatMakeNoSense) {
  ImportOptions options;
  options.max_size = -1;
  ExpectError<UsageError>([&] { options.Check(); }, {"max-size is -1"});
  options = {};
  options.holdout = 1;
  ExpectError<UsageError>([&] { options.Check(); }, {"holdout is 1"});
  options = {};
  options.downscale = 0.5;
  ExpectError<UsageError>([&] { options.Check(); }, {"downscale is 0.5"});
  options.downscale = NAN;
  ExpectError<UsageError>([&] { options.Check(); }, {"downscale is nan"});
  options = {};
  options.bounds_in_input = {{0, 0, 0}, {1, -1, 1}};
  ExpectError<UsageError>([&] { options.Check(); }, {"bounds is 0,0,0,1,-1,1; expected"});
  options.bounds_in_input = {{0, 0, 0}, {1, NAN, 1}};
  ExpectError<UsageError>([&] { options.Check(); }, {"bounds is"});
  options.bounds_in_input = {{-INFINITY, 0, 0}, {1, 1, 1}};
  ExpectError<UsageError>([&] { options.Check(); }, {"bounds is -inf"});
}

TEST(FitToMaxSize, KeepsTheShape) {
  EXPECT_EQ(internal::FitToMaxSize(800, 600, 200), glm::ivec2(200, 150));
  EXPECT_EQ(internal::FitToMaxSize(600, 800, 200), glm::ivec2(150, 200));
  EXPECT_EQ(internal::FitToMaxSize(1000, 333, 100), glm::ivec2(100, 33));
  EXPECT_EQ(internal::FitToMaxSize(5000, 1, 100), glm::ivec2(100, 1));
  EXPECT_EQ(internal::FitToMaxSize(64, 48, 64), glm::ivec2(64, 48));
}

TEST(Import, FindsTheBoundsOfLego) {
  const std::filesystem::path lego = test::DatasetsFolder() / "lego";
  if (!std::filesystem::exists(lego))
    GTEST_SKIP() << "no data set at " << lego << " (TETREC_DATASETS)";
  const ScratchFolder folder;
  const Scene scene = ImportDataset(lego, folder.path(), AtSize(100)).scene;
  EXPECT_EQ(scene.ViewsOf(Split::kTest).size(), 25u);  // the folder has three files per view
  const glm::dvec3 min = scene.input_from_world * scene.subject_bounds.min;
  const glm::dvec3 max = scene.input_from_world * scene.subject_bounds.max;
  // The model's extent is known to a few hundredths; no view is from below, where the hull sags by
  // 0.1.
  const Bounds3 model{{-0.63, -1.14, -0.48}, {0.63, 1.14, 1.0}};
  EXPECT_TRUE(glm::all(glm::lessThan(min, model.min)) &&
              glm::all(glm::greaterThan(max, model.max)));
  EXPECT_LT(glm::length(min - model.min), 0.3);
  EXPECT_LT(glm::length(max - model.max), 0.25);
}

}  // namespace
}  // namespace tetrec
