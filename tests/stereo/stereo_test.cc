#include "stereo/stereo.h"

#include "core/error.h"
#include "scene/synthetic.h"
#include "stereo/neighbors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace tetrec {
namespace {

SyntheticScene SomeScene(SyntheticKind kind, int points, int views) {
  SyntheticOptions options;
  options.kind = kind;
  options.train_views = views;
  options.validation_views = options.test_views = 0;
  options.width = options.height = 96;
  options.rays_per_side = 2;
  options.points = points;
  return MakeSyntheticScene(options);
}

std::vector<StereoView> ViewsOf(const SyntheticScene& synthetic) {
  std::vector<StereoView> views;
  for (const int i : synthetic.scene.ViewsOf(Split::kTrain)) {
    views.push_back(
        MakeStereoView(synthetic.scene, uint32_t(i), synthetic.images[size_t(i)], 1000));
  }
  return views;
}

// True if the surface is within about `tolerance` of the point: some of the corners of a cube and
// of an octahedron around it are inside, others outside.
bool IsOnSubject(SyntheticKind kind, const DensePoint& point, double tolerance) {
  int inside = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1, 1}) {
      glm::dvec3 step(0.0);
      step[axis] = sign * tolerance;
      inside += IsInSubject(kind, point.position + step) ? 1 : 0;
    }
  }
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const glm::dvec3 step = tolerance / std::sqrt(3.0) * corner;
    inside += IsInSubject(kind, point.position + step) ? 1 : 0;
  }
  return inside > 0 && inside < 14;
}

TEST(FindDepths, PutsPointsOnTheSurfaceOfAMaskedSubjectWithoutSparsePoints) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kTwoBalls, 0, 30);
  const std::vector<StereoView> views = ViewsOf(synthetic);
  StereoOptions options;
  options.fusion.max_points = 1500;
  const StereoResult result = FindDepths(synthetic.scene, views, options);
  ASSERT_GT(result.fusion.points.size(), 500u);
  size_t right = 0;
  for (const DensePoint& point : result.fusion.points) {
    // Five pixels at the cameras' distance of 3. The texture is smooth and the balls are 30 to 45
    // pixels wide, so that windows at their rims show the background too.
    const double tolerance = 5 * 3 / views[0].camera.fx;
    right += IsOnSubject(SyntheticKind::kTwoBalls, point, tolerance) ? 1 : 0;
    EXPECT_GE(point.views.size(), 1u);
  }
  EXPECT_GT(double(right), 0.85 * double(result.fusion.points.size()));
  for (size_t i = 0; i < result.maps.size(); ++i) {
    for (size_t p = 0; p < result.maps[i].depth.size(); ++p) {
      if (views[i].kinds[p] == PixelKind::kEmpty) {
        ASSERT_EQ(result.maps[i].depth[p], 0);
      }
    }
  }
}

TEST(FindDepths, FindsARoomAndWhatIsInIt) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom, 400, 60);
  const std::vector<StereoView> views = ViewsOf(synthetic);
  StereoOptions options;
  options.slanted.rounds = 1;
  const StereoResult result = FindDepths(synthetic.scene, views, options);
  EXPECT_TRUE(result.is_slanted);
  EXPECT_GT(result.confirmed, result.pixels / 2);
  size_t right = 0;
  for (const DensePoint& point : result.fusion.points) {
    const glm::dvec3 p = glm::abs(point.position);
    const bool is_on_wall = std::abs(std::max({p.x, p.y, p.z}) - 4) < 0.3;
    right += is_on_wall || IsOnSubject(SyntheticKind::kRoom, point, 0.3) ? 1 : 0;
  }
  EXPECT_GT(double(right), 0.8 * double(result.fusion.points.size()));
}

TEST(FuseDepths, FindsTheSamePointsInParts) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kTwoBalls, 0, 12);
  const std::vector<StereoView> views = ViewsOf(synthetic);
  const StereoResult result = FindDepths(synthetic.scene, views, {});
  const auto fused = [&](size_t max_points, size_t pixels_at_once) {
    FusionOptions options;
    options.max_points = max_points;
    options.pixels_at_once = pixels_at_once;
    Fusion fusion = FuseDepths(result.maps, views, options);
    std::ranges::sort(fusion.points, [](const DensePoint& a, const DensePoint& b) {
      return std::tie(a.position.x, a.position.y, a.position.z) <
             std::tie(b.position.x, b.position.y, b.position.z);
    });
    return fusion;
  };
  const size_t pixels = result.fusion.pixels;
  const Fusion whole = fused(pixels, pixels + 1), parts = fused(pixels, pixels / 6);
  EXPECT_EQ(parts.pixels, pixels);
  EXPECT_EQ(parts.contradicted, whole.contradicted);
  ASSERT_EQ(parts.points.size(), whole.points.size());
  for (size_t i = 0; i < whole.points.size(); ++i) {
    EXPECT_EQ(parts.points[i].position, whole.points[i].position);
    EXPECT_EQ(parts.points[i].views, whole.points[i].views);
  }
  // One part stands for all when the spacing is sought.
  const double spacing_px = fused(pixels / 20, pixels + 1).spacing_px;
  EXPECT_NEAR(fused(pixels / 20, pixels / 6).spacing_px, spacing_px, 0.1 * spacing_px);
}

TEST(FindDepths, KeepsNothingWithoutEnoughEvidence) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom, 400, 12);
  const std::vector<StereoView> views = ViewsOf(synthetic);
  StereoOptions options;
  options.evidence = 1'000'000;  // 77,000 in maps of 96 x 96 pixels
  options.slant_below = 0;
  const StereoResult result = FindDepths(synthetic.scene, views, options);
  EXPECT_EQ(result.confirmed, 0u);
  EXPECT_FALSE(result.is_slanted);
}

TEST(FindDepths, FindsNothingInASinglePhoto) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kBall, 0, 2);
  const std::vector<StereoView> one = {ViewsOf(synthetic)[0]};
  const StereoResult result = FindDepths(synthetic.scene, one, {});
  EXPECT_EQ(result.confirmed, 0u);
  EXPECT_EQ(result.views_without, 1u);
  EXPECT_FALSE(result.is_slanted);
  EXPECT_TRUE(result.fusion.points.empty());
}

TEST(ChooseNeighbors, PrefersViewsAtAUsefulAngle) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom, 200, 60);
  const std::vector<StereoView> views = ViewsOf(synthetic);
  const auto neighbors = ChooseNeighbors(views, OverlapPoints(synthetic.scene), 3);
  for (size_t i = 0; i < views.size(); ++i) {
    const glm::dvec3 center = views[i].cam_from_world.Inverse().translation;
    ASSERT_EQ(neighbors[i].size(), 3u);
    for (const uint32_t j : neighbors[i]) {
      ASSERT_NE(size_t(j), i);
      // Cameras on a sphere of radius 3 around the ball, but what they see is the room behind it.
      EXPECT_LT(glm::distance(center, views[j].cam_from_world.Inverse().translation), 3);
    }
  }
}

TEST(ChooseNeighbors, TakesOneOfSeveralViewsFromOnePlace) {
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom, 200, 20);
  std::vector<StereoView> views = ViewsOf(synthetic);
  const size_t count = views.size();
  for (size_t i = 0; i < count; ++i) views.push_back(views[i]);  // its twin is i + count
  const auto neighbors = ChooseNeighbors(views, OverlapPoints(synthetic.scene), 6);
  for (size_t i = 0; i < views.size(); ++i) {
    std::set<size_t> places{i % count};
    for (const uint32_t j : neighbors[i]) EXPECT_TRUE(places.insert(j % count).second) << i;
    EXPECT_GT(places.size(), 3u);
  }
}

TEST(FindDepthRange, ReachesBeyondThePointsOfAPhoto) {
  SyntheticScene synthetic = SomeScene(SyntheticKind::kRoom, 200, 12);
  const StereoView view = ViewsOf(synthetic)[0];
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const std::vector<glm::dvec3> points(10, world_from_cam * glm::dvec3(0, 0, 2));
  const DepthRange range = FindDepthRange(view, points, synthetic.scene);
  EXPECT_NEAR(range.nearest, 1.5, 1e-9);
  EXPECT_NEAR(range.farthest, 16, 1e-9) << "a background in which nothing was matched";
  EXPECT_TRUE(FindDepthRange(view, std::span(points).first(4), synthetic.scene).IsEmpty());
}

TEST(StereoOptions, AreChecked) {
  StereoOptions options;
  EXPECT_NO_THROW(options.Check());
  options.neighbors = 0;
  EXPECT_THROW(options.Check(), UsageError);
  options = {};
  options.tolerance = NAN;
  EXPECT_THROW(options.Check(), UsageError);
  options = {};
  options.evidence = 0;
  EXPECT_THROW(options.Check(), UsageError);
  options = {};
  options.patch_tolerance = 0;
  EXPECT_THROW(options.Check(), UsageError);
}

}  // namespace
}  // namespace tetrec
