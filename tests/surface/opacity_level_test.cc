#include "surface/opacity_level.h"

#include "mesh/mesh_facts.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr double kCameraDistance = 4;

// The unit ball from a camera on the z axis, turned about the y axis; exact depths.
SeenDepth BallSeenFrom(double turn, double radius = 1) {
  SeenDepth view;
  view.camera = {100, 100, 150, 150, 50, 50};
  const double c = std::cos(turn), s = std::sin(turn);
  view.cam_from_world = {glm::dmat3(c, 0, -s, 0, 1, 0, s, 0, c), glm::dvec3(0, 0, kCameraDistance)};
  view.depth = MakeDepthMap(100, 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      const glm::dvec3 d = view.camera.CamFromImage({x + 0.5, y + 0.5});
      const double a = glm::dot(d, d), b = kCameraDistance;
      const double root = b * b - a * (b * b - radius * radius);
      if (root > 0) view.depth.At(x, y) = float((b - std::sqrt(root)) / a);
    }
  }
  return view;
}

std::vector<SeenDepth> BallFromAround() {
  std::vector<SeenDepth> views;
  for (int i = 0; i < 8; ++i) views.push_back(BallSeenFrom(i * M_PI / 4));
  return views;
}

TEST(Opacity, SignChangesAtTheDepthWhereRaysAreStopped) {
  const std::vector<SeenDepth> views = BallFromAround();
  EXPECT_GT(SolidityAt({0, 0, -0.97}, views), 0);
  EXPECT_LT(SolidityAt({0, 0, -1.03}, views), 0);
  EXPECT_EQ(SolidityAt({0, 0, 0}, views), 1);     // hidden from all
  EXPECT_EQ(SolidityAt({0, 1.2, 0}, views), -1);  // free in all: these rays are never stopped
  EXPECT_EQ(SolidityAt({0, 50, 0}, views), -1);   // in no image
  EXPECT_EQ(SolidityAt({0, 0, 0}, {}), -1);
}

TEST(Opacity, ASingleViewThatErrsMakesNoHole) {
  std::vector<SeenDepth> views = BallFromAround();
  views.push_back(views[0]);
  views.push_back(BallSeenFrom(0, 0.9));
  EXPECT_GT(SolidityAt({0, 0, -0.95}, views), 0);
}

// Many rays through a wall, which are not known behind the place where they have lost some of their
// light, do not outvote one that is stopped there.
TEST(Opacity, RaysDoNotCountWhereTheyAreNotKnown) {
  SeenDepth passing = BallSeenFrom(0);
  passing.free_until = passing.depth;
  std::ranges::fill(passing.depth.depth, kNoDepth);
  std::vector<SeenDepth> views(9, passing);
  EXPECT_EQ(SolidityAt({0, 0, -1.03}, views), -1);
  views.push_back(BallSeenFrom(0));
  EXPECT_GT(SolidityAt({0, 0, -0.97}, views), 0);
  EXPECT_LT(SolidityAt({0, 0, -1.03}, views), 0);
  EXPECT_EQ(SolidityAt({0, 0, 0}, views), 1) << "hidden";
  for (SeenDepth& view : views) view.free_until = {};
  EXPECT_LT(SolidityAt({0, 0, -0.97}, views), 0) << "known to be free";
}

// A quarter of a band in front of what one camera sees, and almost a band behind what another does,
// which therefore does not close the gap.
TEST(Opacity, ASurfaceFarInFrontOfAPointClosesNoGap) {
  const glm::dvec3 point(0, 0, -1);
  const double band = 7 * (kCameraDistance - 1) / 150;
  const std::vector<SeenDepth> views = {BallSeenFrom(0, 1 - 0.25 * band),
                                        BallSeenFrom(0, 1 + 0.9 * band)};
  EXPECT_LT(SolidityAt(point, views), 0);
  EXPECT_GT(SolidityAt(point, std::span(views).subspan(1)), 0.5);
  const std::vector<SeenDepth> near = {views[0], BallSeenFrom(0, 1 + 0.4 * band)};
  EXPECT_GT(SolidityAt(point, near), 0);
}

TEST(Opacity, CutsOfACoarseMeshLieOnTheSurface) {
  const std::vector<SeenDepth> views = BallFromAround();
  const LevelSet set = MarchToOpacity(JitteredBox(10), views);
  ASSERT_GT(set.cuts.size(), 300u);
  EXPECT_TRUE(MeasureMesh(AsTriangles(set)).IsClosedManifold());
  // Near the poles, which all cameras see at a slant, depths are less exact than a pixel.
  double sum = 0;
  size_t count = 0;
  for (const glm::vec3& p : set.positions) {
    if (std::abs(p.y) > 0.7) continue;
    sum += std::abs(glm::length(glm::dvec3(p)) - 1);
    ++count;
  }
  const double pixel = 1 / 50.0;
  EXPECT_LT(sum / double(count), 0.3 * pixel);
}

// One camera sees half of the ball; what closes it behind is the edge of the ball's shadow.
TEST(Opacity, ThePartThatIsSeenEndsWhereTheShadowBegins) {
  const std::vector<SeenDepth> views = {BallSeenFrom(0)};
  const LevelSet all = MarchToOpacity(JitteredBox(12), views);
  const LevelSet seen = SeenPart(all, views, 0.1);
  const auto behind = [](const LevelSet& set) {
    return std::count_if(set.positions.begin(), set.positions.end(),
                         [](const glm::vec3& p) { return p.z > 0.5f; });
  };
  EXPECT_GT(behind(all), 50);
  EXPECT_EQ(behind(seen), 0);
  // The camera's rays touch the ball at z = -1/4. No skirt is left there, where the shadow begins.
  EXPECT_TRUE(std::ranges::none_of(seen.positions, [](const glm::vec3& p) { return p.z > -0.2f; }));
  const auto in_front = [](const LevelSet& set) {
    return std::count_if(set.positions.begin(), set.positions.end(),
                         [](const glm::vec3& p) { return p.z < -0.6f; });  // above 12 degrees
  };
  EXPECT_GT(in_front(all), 50);
  EXPECT_EQ(in_front(seen), in_front(all));
  // A patch as large as the shadow is a gap if gaps may be so large.
  EXPECT_EQ(SeenPart(all, views, 100).triangles.size(), all.triangles.size());
}

// A floor y = 0. Beyond z = `edge`, seen from the camera of FloorFromAbove, it is `drop` lower.
// It has `side` x `side` vertices.
LevelSet Floor(double edge, double drop, uint32_t side = 21) {
  LevelSet set;
  for (uint32_t j = 0; j < side; ++j) {
    for (uint32_t i = 0; i < side; ++i) {
      const double z = -0.5 + double(j) / (side - 1);
      set.positions.emplace_back(-0.5 + double(i) / (side - 1), z < edge ? -drop : 0.0, z);
      if (i == 0 || j == 0) continue;
      const uint32_t v = j * side + i;
      set.triangles.emplace_back(v, v - side, v - 1);
      set.triangles.emplace_back(v - 1, v - side, v - side - 1);
    }
  }
  set.cuts.resize(set.positions.size());
  set.tets.resize(set.triangles.size());
  return set;
}

// From a camera at this height, at a distance of 4; at 0.55, it sees the floor at an angle of some
// 8 degrees. Its rays end at this share of their way to the floor.
SeenDepth FloorFromAbove(double height, double share = 1) {
  SeenDepth view;
  view.camera = {200, 200, 150, 150, 100, 80};
  view.cam_from_world = {glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0, height, 4)};
  view.depth = MakeDepthMap(200, 200);
  for (int y = 0; y < 200; ++y) {
    const double down = view.camera.CamFromImage({0.5, y + 0.5}).y;
    for (int x = 0; x < 200 && down > 0; ++x) view.depth.At(x, y) = float(share * height / down);
  }
  return view;
}

TEST(Opacity, AFloorAtAFlatAngleStaysUnlessItLeadsToWhatIsHidden) {
  const std::vector<SeenDepth> views = {FloorFromAbove(0.55)};
  const LevelSet whole = Floor(-1, 0), broken = Floor(0, 1);
  EXPECT_EQ(SeenPart(whole, views, 0.1).triangles.size(), whole.triangles.size());
  EXPECT_TRUE(SeenPart(broken, views, 0.1).triangles.empty());
}

// Something hides a strip of the floor, z from -0.1 to 0.1.
TEST(Opacity, ANarrowGapInWhatIsSeenIsClosed) {
  SeenDepth view = FloorFromAbove(2);
  for (int y = 0; y < 200; ++y) {
    const double down = view.camera.CamFromImage({0.5, y + 0.5}).y;
    if (down <= 0 || std::abs(4 - 2 / down) > 0.1) continue;
    for (int x = 0; x < 200; ++x) view.depth.At(x, y) *= 0.5f;
  }
  const LevelSet floor = Floor(-1, 0);
  const std::vector<SeenDepth> views = {view};
  const size_t seen = SeenPart(floor, views, 0.05).triangles.size();
  EXPECT_GT(seen, floor.triangles.size() / 2);
  EXPECT_LT(seen, 0.9 * double(floor.triangles.size()));
  EXPECT_EQ(SeenPart(floor, views, 0.5).triangles.size(), floor.triangles.size());
}

// Something hides the floor beyond z = 0 but for a strip of it, 0.09 wide.
TEST(Opacity, ARagThatHangsFromABorderIsDropped) {
  SeenDepth view = FloorFromAbove(2);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const glm::dvec3 ray = view.camera.CamFromImage({x + 0.5, y + 0.5});
      const bool is_beyond = ray.y > 0 && 2 > 4 * ray.y;
      if (is_beyond && std::abs(ray.x) > 0.045 / 2 * ray.y) view.depth.At(x, y) *= 0.5f;
    }
  }
  const LevelSet floor = Floor(-1, 0, 101);
  const std::vector<SeenDepth> views = {view};
  const auto count_between = [](const LevelSet& set, float first_z, float last_z) {
    return std::ranges::count_if(set.positions,
                                 [&](const glm::vec3& p) { return p.z > first_z && p.z < last_z; });
  };
  const LevelSet with_rag = SeenPart(floor, views, 0.1), without = SeenPart(floor, views, 0.5);
  EXPECT_GT(count_between(with_rag, -0.5f, -0.3f), 80);
  EXPECT_EQ(count_between(without, -0.5f, -0.3f), 0);
  EXPECT_EQ(count_between(without, 0.05f, 0.5f), count_between(floor, 0.05f, 0.5f));
}

// Of twenty cameras, two must face a surface: the rays of one may end anywhere as far as the others
// know.
TEST(Opacity, WhatFacesOneOfManyCamerasIsLeftOutIfItLeadsToWhatIsHidden) {
  const LevelSet broken = Floor(0, 1);
  const SeenDepth faced = FloorFromAbove(2), other = FloorFromAbove(2, 0.5);
  std::vector<SeenDepth> views(19, other);
  views.push_back(faced);
  EXPECT_TRUE(SeenPart(broken, views, 0.1).triangles.empty());
  views.front() = faced;
  const size_t seen = SeenPart(broken, views, 0.1).triangles.size();
  EXPECT_GT(seen, broken.triangles.size() / 3);
  EXPECT_LT(seen, broken.triangles.size());
  const std::vector<SeenDepth> few = {faced, other};
  EXPECT_EQ(SeenPart(broken, few, 0.1).triangles.size(), seen);
}

}  // namespace
}  // namespace tetrec
