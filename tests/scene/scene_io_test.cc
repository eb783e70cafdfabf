#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scene/scene.h"
#include "scratch_folder.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace tetrec {
namespace {

glm::dmat3 Turn(double angle) {
  return glm::dmat3(
      glm::rotate(glm::dmat4(1.0), angle, glm::normalize(glm::dvec3(1.0, 0.3, -0.7))));
}

Scene SomeScene() {
  Scene scene;
  scene.cameras = {{64, 48, 70.1, 70.2, 31.5, 24.25}, {32, 32, 40, 40, 16, 16}};
  scene.views = {
      {"train/a", "images/train/a.png", 0, {Turn(0.4), {0.1, -2, 1.0 / 3}}, Split::kTrain},
      {"val/b", "images/val/b.png", 1, {Turn(1.4), {1e-7, 2, 5}}, Split::kValidation},
      {"test/c", "images/test/c.png", 1, {Turn(-2.4), {3, 2, 5}}, Split::kTest}};
  scene.points = {{{0.1, 0.2, -1e-9}, {1, 2, 255}, 0.5f, 3}, {{-7, 8, 9}, {0, 0, 0}, 1.25f, 40}};
  scene.subject_bounds = {{-1, -0.5, -0.25}, {1, 0.5, 0.25}};
  scene.background = Background::kBlack;
  scene.has_alpha = true;
  scene.input_from_world = {2.5, Turn(0.2), {10, 20, 30}};
  return scene;
}

void WriteWithPictures(const ScratchFolder& folder, const Scene& scene) {
  for (const View& view : scene.views) folder.Write(view.image, "only its presence is checked");
  WriteScene(folder.path(), scene);
}

TEST(SceneFile, ReadsBackWhatWasWritten) {
  const ScratchFolder folder;
  const Scene scene = SomeScene();
  WriteWithPictures(folder, scene);
  const Scene read = ReadScene(folder.path());

  ASSERT_EQ(read.cameras.size(), scene.cameras.size());
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    EXPECT_EQ(read.cameras[i].width, scene.cameras[i].width);
    EXPECT_EQ(read.cameras[i].height, scene.cameras[i].height);
    EXPECT_EQ(read.cameras[i].fx, scene.cameras[i].fx);
    EXPECT_EQ(read.cameras[i].fy, scene.cameras[i].fy);
    EXPECT_EQ(read.cameras[i].cx, scene.cameras[i].cx);
    EXPECT_EQ(read.cameras[i].cy, scene.cameras[i].cy);
  }
  ASSERT_EQ(read.views.size(), scene.views.size());
  for (size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(read.views[i].name, scene.views[i].name);
    EXPECT_EQ(read.views[i].image, scene.views[i].image);
    EXPECT_EQ(read.views[i].camera, scene.views[i].camera);
    EXPECT_EQ(read.views[i].split, scene.views[i].split);
    EXPECT_EQ(read.views[i].cam_from_world.rotation, scene.views[i].cam_from_world.rotation);
    EXPECT_EQ(read.views[i].cam_from_world.translation, scene.views[i].cam_from_world.translation);
  }
  ASSERT_EQ(read.points.size(), scene.points.size());
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_EQ(read.points[i].position, scene.points[i].position);
    EXPECT_EQ(read.points[i].color_srgb, scene.points[i].color_srgb);
    EXPECT_EQ(read.points[i].reprojection_error_px, scene.points[i].reprojection_error_px);
    EXPECT_EQ(read.points[i].track_length, scene.points[i].track_length);
  }
  EXPECT_EQ(read.subject_bounds.min, scene.subject_bounds.min);
  EXPECT_EQ(read.subject_bounds.max, scene.subject_bounds.max);
  EXPECT_EQ(read.background, scene.background);
  EXPECT_EQ(read.has_alpha, scene.has_alpha);
  EXPECT_EQ(read.input_from_world.scale, scene.input_from_world.scale);
  EXPECT_EQ(read.input_from_world.rotation, scene.input_from_world.rotation);
  EXPECT_EQ(read.input_from_world.translation, scene.input_from_world.translation);
}

TEST(SceneFile, WithoutPointsLeavesNoPointsFileOfAnEarlierRun) {
  const ScratchFolder folder;
  Scene scene = SomeScene();
  WriteWithPictures(folder, scene);
  scene.points.clear();
  WriteScene(folder.path(), scene);
  EXPECT_FALSE(std::filesystem::exists(folder / "points.ply"));
  EXPECT_TRUE(ReadScene(folder.path()).points.empty());
}

TEST(SceneFile, RefusesEveryBrokenFieldByName) {
  using Json = nlohmann::json;
  struct Case {
    const char* message;
    std::function<void(Json&)> spoil;
  };
  const Case cases[] = {
      {"schema is 2; expected 1", [](Json& j) { j["schema"] = 2; }},
      {"schema is missing", [](Json& j) { j.erase("schema"); }},
      {"background is \"green\"; expected white, black or scene",
       [](Json& j) { j["background"] = "green"; }},
      {"has_alpha is 1; expected true or false", [](Json& j) { j["has_alpha"] = 1; }},
      {"has_masks is \"no\"; expected true or false", [](Json& j) { j["has_masks"] = "no"; }},
      {"has_masks is true although has_alpha is", [](Json& j) { j["has_masks"] = true; }},
      {"subject_bounds is an empty box", [](Json& j) { j["subject_bounds"]["min"][1] = 0.5; }},
      {"subject_bounds.max has 4 items; expected 3 numbers",
       [](Json& j) { j["subject_bounds"]["max"].push_back(1); }},
      {"input_from_world.scale is 0; expected 1e-12 to",
       [](Json& j) { j["input_from_world"]["scale"] = 0; }},
      {"cameras is \"none\"; expected an array", [](Json& j) { j["cameras"] = "none"; }},
      {"cameras is empty; expected at least one camera",
       [](Json& j) { j["cameras"] = Json::array(); }},
      {"cameras[0].width is 0; expected 1 to 65536", [](Json& j) { j["cameras"][0]["width"] = 0; }},
      {"cameras[0].width is 64.5; expected a whole number",
       [](Json& j) { j["cameras"][0]["width"] = 64.5; }},
      {"cameras[1].height is 18446744073709551615; expected 1 to 65536",
       [](Json& j) { j["cameras"][1]["height"] = 18446744073709551615u; }},
      {"cameras[1].fx is -40; expected 0.001 to", [](Json& j) { j["cameras"][1]["fx"] = -40; }},
      {"cameras[1].cy is null; expected a number",
       [](Json& j) { j["cameras"][1]["cy"] = nullptr; }},
      {"views is empty; expected at least one view", [](Json& j) { j["views"] = Json::array(); }},
      {"views[1] is 3; expected an object", [](Json& j) { j["views"][1] = 3; }},
      {"views[1].camera is 2; expected 0 to 1", [](Json& j) { j["views"][1]["camera"] = 2; }},
      {"views[1].camera is -1; expected 0 to 1", [](Json& j) { j["views"][1]["camera"] = -1; }},
      {"views[2].name \"train/a\" names an earlier view too",
       [](Json& j) { j["views"][2]["name"] = "train/a"; }},
      {"views[2].name is 7; expected text", [](Json& j) { j["views"][2]["name"] = 7; }},
      {"views[2].name is \"../c\"; expected a relative path",
       [](Json& j) { j["views"][2]["name"] = "../c"; }},
      {"views[0].image is \"../outside.png\", which leaves the scene folder",
       [](Json& j) { j["views"][0]["image"] = "../outside.png"; }},
      {"views[0].image is \"/etc/passwd\", which leaves the scene folder",
       [](Json& j) { j["views"][0]["image"] = "/etc/passwd"; }},
      {"images/none.png; run the stage that wrote the scene again",
       [](Json& j) { j["views"][0]["image"] = "images/none.png"; }},
      {"views[0].image is missing: ",
       [](Json& j) { j["views"][0]["image"] = std::string(5000, 'x'); }},
      {"views[0].split is \"val\"; expected train, validation or test",
       [](Json& j) { j["views"][0]["split"] = "val"; }},
      {"views[0].cam_from_world.rotation has 2 items; expected 3 rows",
       [](Json& j) { j["views"][0]["cam_from_world"]["rotation"].erase(2); }},
      {"views[0].cam_from_world.rotation is not a rotation: R^T R is off by",
       [](Json& j) { j["views"][0]["cam_from_world"]["rotation"][0][0] = 3.0; }},
      {"views[0].cam_from_world.rotation is not a rotation",
       [](Json& j) {  // a mirror
         j["views"][0]["cam_from_world"]["rotation"] = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
       }},
      {"views[0].cam_from_world.translation[2] is \"near\"; expected a number",
       [](Json& j) { j["views"][0]["cam_from_world"]["translation"][2] = "near"; }},
      {"points.ply: has 2 points, but scene.json states 3", [](Json& j) { j["point_count"] = 3; }},
      {"point_count is -1; expected 0 to", [](Json& j) { j["point_count"] = -1; }},
  };
  const ScratchFolder folder;
  WriteWithPictures(folder, SomeScene());
  const nlohmann::json good = ReadJson(folder / "scene.json");
  for (const Case& broken : cases) {
    SCOPED_TRACE(broken.message);
    nlohmann::json json = good;
    broken.spoil(json);
    WriteJson(folder / "scene.json", json);
    ExpectError<DataError>([&] { ReadScene(folder.path()); },
                           {folder.path().string(), broken.message});
  }
}

TEST(SceneFile, RefusesBrokenPointsByPropertyAndVertex) {
  const ScratchFolder folder;
  WriteWithPictures(folder, SomeScene());
  const std::string good =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float reprojection_error\nproperty uint track_length\nend_header\n"
      "0 0 0 1 2 3 0.5 3\n1 7 0 4 5 6 0.25 4\n";
  folder.Write("points.ply", good);
  EXPECT_EQ(ReadScene(folder.path()).points[1].position.y, 7);
  const auto refused = [&](const std::string& from, const std::string& to, const char* message) {
    std::string spoilt = good;
    folder.Write("points.ply", spoilt.replace(spoilt.find(from), from.size(), to));
    ExpectError<DataError>([&] { ReadScene(folder.path()); }, {"points.ply: ", message});
  };
  refused("1 7 0", "1 nan 0", "y of vertex 1 is nan; expected");
  refused("0.5 3", "-0.5 3", "reprojection_error of vertex 0 is -0.5; expected 0 to");
  refused("uchar green", "uchar grey", "vertex property 'green' is missing");
  refused("element vertex", "element corner", "has no vertices");
}

TEST(SceneFile, IsNotWrittenWithWhatCouldNotBeReadBack) {
  const ScratchFolder folder;
  Scene scene = SomeScene();
  scene.views[1].cam_from_world.translation.y = std::nan("");
  ExpectError<DataError>([&] { WriteScene(folder.path(), scene); },
                         {"views[1].cam_from_world.translation[1] is null; expected a finite"});
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.json"));
}

TEST(Scene, HeldOutViewsAreTestElseValidation) {
  Scene scene = SomeScene();
  EXPECT_EQ(scene.HeldOutViews(), std::vector<int>{2});
  scene.views[2].split = Split::kTrain;
  EXPECT_EQ(scene.HeldOutViews(), std::vector<int>{1});
  EXPECT_EQ(scene.ViewsOf(Split::kTrain), (std::vector<int>{0, 2}));
}

}  // namespace
}  // namespace tetrec
