// The subject's bounds from a scene's points and cameras.
#include "scene/subject_bounds.h"

#include "scene/synthetic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// A ball in the middle of a room with walls at 4, seen from all around.
Scene RoomScene() {
  SyntheticOptions options;
  options.kind = SyntheticKind::kRoom;
  options.width = options.height = 16;
  options.points = 3000;
  return MakeSyntheticScene(options).scene;
}

// The same scene in another frame, as COLMAP would give it.
Scene InOtherFrame(Scene scene, const Similarity3& other_from_scene) {
  const Similarity3 scene_from_other = other_from_scene.Inverse();
  for (View& view : scene.views) {
    const glm::dvec3 center = other_from_scene * view.cam_from_world.Inverse().translation;
    view.cam_from_world.rotation = view.cam_from_world.rotation * scene_from_other.rotation;
    view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
  }
  for (ScenePoint& point : scene.points) point.position = other_from_scene * point.position;
  return scene;
}

TEST(Subject, TheBallIsSeparatedFromTheWallsBehindIt) {
  const Scene room = RoomScene();
  const Subject subject = FindSubject(room);
  const Similarity3 room_from_world = subject.input_from_world;
  size_t inside = 0, ball = 0, walls = 0, walls_inside = 0;
  for (const ScenePoint& point : room.points) {
    const bool in_box =
        subject.bounds_in_world.Contains(room_from_world.Inverse() * point.position);
    const bool on_wall = std::max({std::abs(point.position.x), std::abs(point.position.y),
                                   std::abs(point.position.z)}) > 3.9;
    (on_wall ? walls : ball) += 1;
    (on_wall ? walls_inside : inside) += in_box;
  }
  ASSERT_GT(ball, 100u);
  ASSERT_GT(walls, 100u);
  // Trimming removes 1 % at each end, and the margin restores most of it.
  EXPECT_GT(double(inside), 0.97 * double(ball));
  EXPECT_EQ(walls_inside, 0u);
  const glm::dvec3 size = subject.bounds_in_world.Size();
  EXPECT_NEAR(std::max({size.x, size.y, size.z}), 2, 1e-12);
  EXPECT_NEAR(glm::length(subject.bounds_in_world.Center()), 0, 1e-12);
}

// A ball at the end of a thin rod above the subject, by a handful of points: so few that trimming
// removes them.
TEST(Subject, AGroupOfPointsThatAllViewsSeeIsInsideHoweverSmall) {
  Scene room = RoomScene();
  const Bounds3 before = FindSubject(room).bounds_in_world;
  const Similarity3 room_from_world = FindSubject(room).input_from_world;
  const glm::dvec3 top = room_from_world * glm::dvec3(0, 0, before.max.z + 0.1);
  ScenePoint point;
  point.track_length = 3;
  point.position = top;
  room.points.push_back(point);  // one alone is an outlier
  EXPECT_FALSE(FindSubject(room).bounds_in_world.Size().z > before.Size().z + 0.05);
  EXPECT_EQ(FindSubject(room).outside, 1u);
  for (int i = 1; i < 6; ++i) {
    point.position = top + glm::dvec3(0.01 * i, 0, 0);
    room.points.push_back(point);
  }
  const Subject subject = FindSubject(room);
  EXPECT_TRUE(
      subject.bounds_in_world.Contains(subject.input_from_world.Inverse() * point.position));
  EXPECT_EQ(subject.outside, 0u);
}

// Wherever it is, and however it lies to the cells by which its points are found.
TEST(Subject, AGroupOfFewerPointsIsAnOutlier) {
  const Scene room = RoomScene();
  const Subject before = FindSubject(room);
  // Points within this distance are one group [world units, in which the box's side is 2].
  const double reach = 0.05 / 1.1 * 2;
  for (int direction = 0; direction < 24; ++direction) {
    glm::dvec3 place(0.13 * (direction % 5 - 2));
    const int axis = direction % 3;
    place[axis] = (direction % 2 == 0 ? 1 : -1) * (before.bounds_in_world.max[axis] + 0.07);
    for (const int count : {4, 5}) {
      Scene scene = room;
      for (int i = 0; i < count; ++i) {
        ScenePoint point;
        point.track_length = 3;
        point.position = before.input_from_world *
                         (place + 0.45 * reach * glm::dvec3(i % 2, i / 2 % 2, i == 4 ? 1 : i / 4));
        scene.points.push_back(point);
      }
      EXPECT_EQ(FindSubject(scene).outside, count == 5 ? 0u : 4u) << direction;
    }
  }
}

TEST(Subject, GivenBoundsBecomeTheWorldAndKeepEveryPointOnItsPixel) {
  const Scene before = RoomScene();
  Scene found = before;
  MoveToSubject(found, FindSubject(before));
  Scene given = found;
  MoveToBox(given, {{-1, -0.5, 0}, {3, 1.5, 1}});
  EXPECT_NEAR(given.subject_bounds.Size().x, 2, 1e-12);
  EXPECT_NEAR(given.subject_bounds.Size().z, 0.5, 1e-12);
  EXPECT_NEAR(glm::length(given.subject_bounds.Center()), 0, 1e-12);
  EXPECT_NEAR(
      glm::distance(given.input_from_world * given.points[7].position, before.points[7].position),
      0, 1e-9);
  const View& a = found.views[3];
  const View& b = given.views[3];
  const glm::dvec3 seen = a.cam_from_world * found.points[7].position;
  EXPECT_NEAR(glm::distance(seen, 2.0 * (b.cam_from_world * given.points[7].position)), 0, 1e-9);
}

TEST(Subject, DoesNotDependOnTheInputsFrame) {
  const Scene room = RoomScene();
  const Similarity3 other_from_room{
      0.037,
      glm::mat3_cast(glm::angleAxis(1.1, glm::normalize(glm::dvec3(1, -2, 0.5)))),
      {5, -7, 2}};
  Scene moved = InOtherFrame(room, other_from_room), still = room;
  MoveToSubject(moved, FindSubject(moved));
  MoveToSubject(still, FindSubject(still));
  for (size_t i = 0; i < room.views.size(); ++i) {
    const glm::dvec3 a = still.views[i].cam_from_world.Inverse().translation;
    const glm::dvec3 b = moved.views[i].cam_from_world.Inverse().translation;
    // The least squares' rounding, scaled up by 1 / 0.037.
    EXPECT_NEAR(glm::distance(a, b), 0, 1e-6);
  }
  for (size_t i = 0; i < room.points.size(); i += 100) {
    EXPECT_NEAR(glm::distance(still.points[i].position, moved.points[i].position), 0, 1e-6);
  }
  // Transforming back gives the original frame.
  EXPECT_NEAR(glm::distance(moved.input_from_world * moved.points[0].position,
                            other_from_room * room.points[0].position),
              0, 1e-9);
}

// The images must not change: every point stays on its pixel, in front of the camera.
TEST(Subject, MovingTheWorldKeepsEveryPointOnItsPixel) {
  const Scene before = RoomScene();
  Scene after = before;
  MoveToSubject(after, FindSubject(before));
  for (size_t v = 0; v < before.views.size(); v += 5) {
    const Camera& camera = before.cameras[size_t(before.views[v].camera)];
    for (size_t i = 0; i < before.points.size(); i += 97) {
      const glm::dvec3 a = before.views[v].cam_from_world * before.points[i].position;
      const glm::dvec3 b = after.views[v].cam_from_world * after.points[i].position;
      if (a.z < 0.1) continue;
      EXPECT_NEAR(glm::distance(camera.ImageFromCam(a), camera.ImageFromCam(b)), 0, 1e-8);
    }
  }
}

TEST(Subject, UpIsUprightForCamerasThatLookDownFromOneSide) {
  // A quarter turn of level cameras that all look 40 degrees down: the mean of their own ups is
  // tilted.
  std::vector<View> views;
  for (int i = 0; i <= 10; ++i) {
    const double angle = 0.5 * M_PI * i / 10, down = 40.0 / 180 * M_PI;
    const glm::dvec3 z(-std::cos(angle) * std::cos(down), -std::sin(angle) * std::cos(down),
                       -std::sin(down));
    const glm::dvec3 x = glm::normalize(glm::cross(z, glm::dvec3(0, 0, 1)));
    View view;
    view.cam_from_world.rotation = glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
    views.push_back(view);
  }
  // The weight of the mean direction costs some degrees.
  EXPECT_GT(FindUp(views).z, std::cos(5.0 / 180 * M_PI));
}

// Cameras 9 above a square of 20 x 20, of which each sees 9 x 9, in rows `step` apart.
Scene SurveyScene(double step) {
  Scene scene;
  scene.cameras.push_back({.width = 100, .height = 100, .fx = 100, .fy = 100, .cx = 50, .cy = 50});
  for (int i = 0; i < 36; ++i) {
    View view;
    view.cam_from_world.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    view.cam_from_world.translation = {step * (2.5 - i % 6), step * (i / 6 - 2.5), 9};
    scene.views.push_back(view);
  }
  for (int i = 0; i < 2000; ++i) {
    ScenePoint point;
    point.position = {20 * std::fmod(0.618034 * i, 1.0) - 10, i / 100.0 - 10, 0.5 * (i % 2)};
    point.track_length = 3;
    scene.points.push_back(point);
  }
  return scene;
}

TEST(Subject, ASurveyIsWholeAndWhatAFewStepsShowIsItsMiddle) {
  const auto side = [](const Scene& scene) {
    const Subject subject = FindSubject(scene);
    return subject.input_from_world.scale * subject.bounds_in_world.Size().x;
  };
  EXPECT_GT(side(SurveyScene(2)), 20);
  EXPECT_LT(side(SurveyScene(2)), 23);
  EXPECT_LT(side(SurveyScene(0.5)), 14);
  // Something far away, in a gap, does not count.
  Scene with_background = SurveyScene(2);
  for (int i = 0; i < 100; ++i) {
    ScenePoint point;
    point.position = {i, 0.3 * i, -40};
    point.track_length = 20;
    with_background.points.push_back(point);
  }
  EXPECT_LT(side(with_background), 23);
  // Cameras one behind the other make a walk forward.
  Scene walk = SurveyScene(0.2);
  walk.cameras[0].fx = walk.cameras[0].fy = 400;
  for (size_t i = 0; i < walk.views.size(); ++i) {
    walk.views[i].cam_from_world.translation.z += double(i);
  }
  EXPECT_LT(side(walk), 18);
}

// Photos from an arc of 56 degrees before a ball, with a wall behind it.
TEST(Subject, AnArcBeforeASubjectIsNotASurvey) {
  Scene scene;
  scene.cameras.push_back({.width = 100, .height = 80, .fx = 90, .fy = 90, .cx = 50, .cy = 40});
  for (int i = 0; i <= 20; ++i) {
    const double angle = (i - 10) / 10.0 * 28 / 180 * M_PI;
    const glm::dvec3 z(-std::sin(angle), 0, -std::cos(angle)), y(0, -1, 0);
    View view;
    view.cam_from_world.rotation = glm::transpose(glm::dmat3(glm::cross(y, z), y, z));
    view.cam_from_world.translation = {0, 0, 4};
    scene.views.push_back(view);
  }
  for (int i = 0; i < 1000; ++i) {
    const double u = std::fmod(0.618034 * i, 1.0), turn = 0.1 * i;
    ScenePoint point;
    point.track_length = 5;
    const double radius = std::sqrt(1 - u * u);
    point.position = {radius * std::cos(turn), radius * std::sin(turn), u};
    scene.points.push_back(point);
    point.position = {10 * u - 5, i / 125.0 - 4, -4};
    scene.points.push_back(point);
  }
  const Subject subject = FindSubject(scene);
  EXPECT_LT(subject.input_from_world.scale * subject.bounds_in_world.Size().x, 2.5);
}

TEST(Subject, UpIsAgainstTheAxesOfCamerasThatLookStraightDownAndTurnBetweenStrips) {
  // Strips towards the east and the west alternate; the cameras sway by some degrees.
  std::vector<View> views;
  for (int i = 0; i < 24; ++i) {
    const double heading = i / 6 % 2 ? M_PI : 0, sway = 0.05;
    const glm::dvec3 z = glm::normalize(glm::dvec3(sway * std::sin(i), sway * std::cos(3 * i), -1));
    const glm::dvec3 ahead(std::cos(heading), std::sin(heading), 0);
    const glm::dvec3 x = glm::normalize(glm::cross(z, ahead));
    View view;
    view.cam_from_world.rotation = glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
    views.push_back(view);
  }
  EXPECT_GT(FindUp(views).z, std::cos(3.0 / 180 * M_PI));
  // With one heading, they might as well be upright photos of a wall.
  EXPECT_LT(std::abs(FindUp({views.data(), 6}).z), 0.1);
}

}  // namespace
}  // namespace tetrec
