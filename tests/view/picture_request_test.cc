// Queries of the page, and of others.
#include "view/picture_request.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

using Query = std::map<std::string, std::string>;

Scene SceneOfOneView() {
  Scene scene;
  scene.cameras = {{400, 300, 500, 510, 190, 160}};
  View view;
  view.name = "a.jpg";
  view.cam_from_world.translation = {1, 2, 3};
  scene.views = {view};
  return scene;
}

const Query kFree = {{"mode", "color"}, {"w", "200"},          {"h", "100"},   {"eye", "1,-2.5,3"},
                     {"fov", "90"},     {"forward", "0,0,-2"}, {"up", "0,1,0"}};

Query With(Query query, const std::string& name, const std::string& value) {
  query[name] = value;
  return query;
}

TEST(PictureRequest, AFreeCameraStandsAtItsEyeAndHasItsFieldOfView) {
  const PictureRequest request = ParsePictureRequest(kFree, SceneOfOneView());
  EXPECT_EQ(request.mode, PictureMode::kColor);
  EXPECT_FALSE(request.is_draft);
  EXPECT_FALSE(request.view);
  const Camera& camera = request.from.camera;
  EXPECT_EQ(camera.width, 200);
  EXPECT_EQ(camera.height, 100);
  EXPECT_NEAR(camera.fy, 50, 1e-9);  // 90 degrees: half of the height
  const glm::dvec3 eye = request.from.cam_from_world.Inverse().translation;
  EXPECT_NEAR(glm::distance(eye, glm::dvec3(1, -2.5, 3)), 0, 1e-12);
  // A point ahead is in the middle, one that is up is above it.
  const glm::dvec3 ahead = request.from.cam_from_world * glm::dvec3(1, -2.5, 2);
  EXPECT_NEAR(glm::distance(camera.ImageFromCam(ahead), glm::dvec2(100, 50)), 0, 1e-9);
  EXPECT_LT(camera.ImageFromCam(request.from.cam_from_world * glm::dvec3(1, -2.4, 2)).y, 50);
}

TEST(PictureRequest, AViewKeepsItsShapeAndItsPoints) {
  const Scene scene = SceneOfOneView();
  const PictureRequest request = ParsePictureRequest(
      {{"mode", "error"}, {"w", "200"}, {"h", "300"}, {"view", "0"}, {"draft", "1"}}, scene);
  EXPECT_TRUE(request.is_draft);
  EXPECT_EQ(request.view, 0);
  const Camera& camera = request.from.camera;
  EXPECT_EQ(camera.width, 200);
  EXPECT_EQ(camera.height, 150);
  const glm::dvec3 point(0.1, -0.2, 1.5);
  EXPECT_NEAR(glm::distance(camera.ImageFromCam(point), 0.5 * scene.cameras[0].ImageFromCam(point)),
              0, 1e-9);
  EXPECT_EQ(request.from.cam_from_world.translation, glm::dvec3(1, 2, 3));
}

TEST(PictureRequest, HostileQueriesAreRefusedByTheNameOfTheParameter) {
  const Scene scene = SceneOfOneView();
  const std::vector<std::pair<Query, std::string>> cases = {
      {{}, "mode"},
      {With(kFree, "mode", "secret"), "mode"},
      {With(kFree, "mode", "photo"), "needs a view"},
      {With(kFree, "mode", "slice"), "slice"},
      {With(With(kFree, "mode", "slice"), "slice", "-1"), "slice"},
      {With(kFree, "w", "99999"), "w is '99999'"},
      {With(kFree, "h", "0"), "h is '0'"},
      {With(kFree, "w", "20.5"), "whole number"},
      {With(kFree, "draft", "2"), "draft"},
      {With(kFree, "eye", "nan,0,0"), "eye is 'nan'"},
      {With(kFree, "eye", "1e300,0,0"), "eye"},
      {With(kFree, "eye", "1,2"), "three numbers"},
      {With(kFree, "eye", "1,2,3,4"), "three numbers"},
      {With(kFree, "eye", "1,2,3x"), "eye is '3x'"},
      {With(kFree, "forward", "0,0,0"), "direction"},
      {With(kFree, "fov", "180"), "fov"},
      {With(kFree, "view", "1"), "view is '1'"},
      {With(kFree, "view", "-1"), "view is '-1'"},
      {With(kFree, "view", "0x0"), "view is '0x0'"},
  };
  for (const auto& [query, part] : cases) {
    ExpectError<UsageError>([&, &query = query] { ParsePictureRequest(query, scene); }, {part});
  }
}

}  // namespace
}  // namespace tetrec
