// Which field and which scene of a run are shown together.
#include "view/session.h"

#include "core/file.h"
#include "image/image.h"
#include "mesh/delaunay.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace tetrec {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

// A run whose stages can be repeated. `age` orders the files, whatever the file system's clock
// resolves.
class RepeatedRun {
 public:
  const std::filesystem::path& path() const { return folder_.path(); }

  // Of one photo for each name.
  void MakeScene(const std::vector<std::string>& names, std::chrono::seconds age) const {
    Scene scene;
    scene.cameras = {{16, 12, 20, 20, 8, 6}};
    scene.subject_bounds = {glm::dvec3(-1), glm::dvec3(1)};
    for (const std::string& name : names) {
      View view;
      view.name = view.image = name;
      scene.views.push_back(view);
      std::filesystem::create_directories(scene_folder());
      WriteImage(scene_folder() / name, MakeImage(16, 12, 3));
    }
    WriteScene(scene_folder(), scene);
    SetAge(scene_folder() / "scene.json", age);
  }

  void SpoilScene(std::chrono::seconds age) const {
    WriteText(scene_folder() / "scene.json", "{}");
    SetAge(scene_folder() / "scene.json", age);
  }

  // A box in front of the camera.
  void MakeStart(std::chrono::seconds age) const {
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) {
      corners.emplace_back((i & 1) ? 2 : -2, (i & 2) ? 2 : -2, (i & 4) ? 2 : 1);
    }
    RadianceField field;
    field.mesh = BuildDelaunay(corners).mesh;
    field.density.assign(8, 1.0f);
    field.color_srgb.assign(8, glm::vec3(0.5f));
    std::filesystem::create_directories(start_file().parent_path());
    WriteField(start_file(), field);
    SetAge(start_file(), age);
  }

  void SpoilStart(std::chrono::seconds age) const {
    WriteText(start_file(), "nothing that is a field");
    SetAge(start_file(), age);
  }

 private:
  static void SetAge(const std::filesystem::path& file, std::chrono::seconds age) {
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() - age);
  }
  std::filesystem::path scene_folder() const { return folder_ / "1_scene"; }
  std::filesystem::path start_file() const { return folder_ / "2_tetrahedra" / "field.tetf"; }

  ScratchFolder folder_;
};

RendererOptions OnTheProcessor() {
  RendererOptions options;
  options.kind = RendererKind::kReference;
  return options;
}

// By the camera of the scene's last view.
PictureRequest LastViewOf(const ShownScene& shown) {
  PictureRequest request;
  request.view = int(shown.scene.views.size()) - 1;
  request.from = {shown.scene.cameras[0], shown.scene.views.back().cam_from_world};
  return request;
}

int NumberIn(const nlohmann::json& facts, const char* name) { return facts[name].get<int>(); }

std::string ProblemOf(const ViewSession& session) {
  return session.Status()["problem"].get<std::string>();
}

TEST(ViewSession, AScenesChangeIsShownTogetherWithTheFieldThatWasMadeFromIt) {
  const RepeatedRun run;
  run.MakeScene({"a.png", "b.png"}, 90s);
  run.MakeStart(80s);
  ViewSession session(run.path(), OnTheProcessor());
  const std::shared_ptr<const ShownScene> before = session.scene();
  const PictureRequest request = LastViewOf(*before);
  EXPECT_TRUE(session.Draw(request, before));
  EXPECT_EQ(NumberIn(session.DescribeScene(), "number"), NumberIn(session.Status(), "scene"));
  // The start is still that of the scene before.
  run.MakeScene({"c.png"}, 70s);
  session.Refresh();
  EXPECT_EQ(session.scene(), before);
  EXPECT_EQ(NumberIn(session.Status(), "loaded"), 1);
  EXPECT_EQ(ProblemOf(session), "");
  run.MakeStart(60s);
  session.Refresh();
  EXPECT_EQ(NumberIn(session.Status(), "loaded"), 2);
  EXPECT_EQ(NumberIn(session.Status(), "scene"), 2);
  const nlohmann::json described = session.DescribeScene();
  EXPECT_EQ(NumberIn(described, "number"), 2);
  ASSERT_EQ(described["views"].size(), 1u);
  EXPECT_EQ(described["views"][0]["name"].get<std::string>(), "c.png");
  EXPECT_FALSE(session.Draw(request, before)) << "the new scene has no such view";
  EXPECT_TRUE(session.Draw(LastViewOf(*session.scene()), session.scene()));
  // A newer field of the same scene.
  const std::shared_ptr<const ShownScene> after = session.scene();
  run.MakeStart(50s);
  session.Refresh();
  EXPECT_EQ(NumberIn(session.Status(), "loaded"), 3);
  EXPECT_EQ(NumberIn(session.Status(), "scene"), 2);
  EXPECT_EQ(session.scene(), after);
}

TEST(ViewSession, WhatCannotBeReadKeepsTheLastFieldAndItsSceneShown) {
  const RepeatedRun run;
  run.MakeScene({"a.png"}, 90s);
  run.MakeStart(80s);
  ViewSession session(run.path(), OnTheProcessor());
  const std::shared_ptr<const ShownScene> before = session.scene();
  const auto expect_unchanged = [&](const std::string& problem) {
    session.Refresh();
    EXPECT_THAT(ProblemOf(session), HasSubstr(problem));
    EXPECT_EQ(NumberIn(session.Status(), "loaded"), 1);
    EXPECT_EQ(session.scene(), before);
    EXPECT_TRUE(session.Draw(LastViewOf(*before), before));
  };
  run.SpoilScene(70s);
  run.MakeStart(60s);
  expect_unchanged("scene.json");
  expect_unchanged("scene.json");  // nothing has changed since
  run.MakeScene({"b.png"}, 50s);
  run.SpoilStart(40s);
  expect_unchanged("field.tetf");
  run.MakeStart(30s);
  session.Refresh();
  EXPECT_EQ(ProblemOf(session), "");
  EXPECT_EQ(NumberIn(session.Status(), "loaded"), 2);
  EXPECT_EQ(session.scene()->scene.views[0].name, "b.png");
  // The scene alone is mended.
  run.SpoilScene(20s);
  run.MakeStart(10s);
  session.Refresh();
  EXPECT_THAT(ProblemOf(session), HasSubstr("scene.json"));
  run.MakeScene({"c.png"}, 5s);
  session.Refresh();
  EXPECT_EQ(ProblemOf(session), "");
  EXPECT_EQ(session.scene()->scene.views[0].name, "c.png");
}

}  // namespace
}  // namespace tetrec
