// Cameras inside of opaque density.
#include "render/buried_cameras.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

// A tet around the origin, dense at one vertex, and cameras that look along z at a box behind it.
RadianceField OneTet(float density, FieldStorage storage) {
  RadianceField field;
  field.mesh.positions = {{-9, -9, -9}, {9, -9, -9}, {0, 9, -9}, {0, 0, 9}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  field.storage = storage;
  field.density.assign(RowCount(field), 0.0f);
  field.density.back() = density;
  field.color_srgb.assign(RowCount(field), glm::vec3(0.5f));
  return field;
}

Scene OneView(const std::string& name, const glm::dvec3& center) {
  Scene scene;
  scene.cameras = {{64, 48, 60, 60, 32, 24}};
  View view;
  view.name = name;
  view.cam_from_world.translation = -center;
  scene.views = {view};
  scene.subject_bounds = {{-1, -1, 20}, {1, 1, 22}};
  return scene;
}

TEST(BuriedCameras, AreThoseWhoseLightIsLostWithinATenthOfTheWayToTheSubject) {
  const Scene scene = OneView("a", glm::dvec3(0, 0, 0));
  // The middle of the tet has half of the density of its vertex; the subject is 20 away.
  for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
    const float at_center = storage == FieldStorage::kVertex ? 0.5f : 1.0f;
    const float limit = float(std::log(2.0)) / 2 / at_center;
    EXPECT_TRUE(BuriedCameras(OneTet(0.99f * limit, storage), scene).empty());
    EXPECT_EQ(BuriedCameras(OneTet(1.01f * limit, storage), scene), std::vector<std::string>{"a"});
    EXPECT_TRUE(BuriedCameras(OneTet(-100, FieldStorage::kVertex), scene).empty());
  }
}

TEST(BuriedCameras, AreJudgedByTheirNearestPointsWhereTheyHaveSome) {
  Scene scene = OneView("a", glm::dvec3(0, 0, 0));
  const RadianceField field = OneTet(2, FieldStorage::kVertex);
  EXPECT_EQ(BuriedCameras(field, scene).size(), 1u);
  for (int i = 0; i < 20; ++i) scene.points.push_back({.position = glm::dvec3(0, 0, 2 + i)});
  // Half of the light is lost after 0.7, which is much of the way to a point 2 away.
  EXPECT_TRUE(BuriedCameras(field, scene).empty());
}

TEST(BuriedCameras, OutsideOfTheMeshThereIsNoDensity) {
  EXPECT_TRUE(
      BuriedCameras(OneTet(1e6f, FieldStorage::kVertex), OneView("a", glm::dvec3(0, 0, -30)))
          .empty());
}

}  // namespace
}  // namespace tetrec
