// Rendered depth against true depth, and the warnings of the report.
#include "core/error.h"
#include "eval/evaluate_depth.h"
#include "eval/fake_run.h"
#include "eval/quality_warnings.h"
#include "eval/true_depth.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>

namespace tetrec {
namespace {

using ::testing::HasSubstr;

const Bounds3 kEverywhere{glm::dvec3(-100), glm::dvec3(100)};

// The depth along z at which the ray through a pixel's centre meets the sphere; 0: never.
double SphereDepth(const Camera& camera, const glm::dvec3& center_in_cam, double radius, int x,
                   int y) {
  const glm::dvec3 d = camera.CamFromImage({x + 0.5, y + 0.5});
  const double a = glm::dot(d, d), b = glm::dot(d, center_in_cam);
  const double inside = b * b - a * (glm::dot(center_in_cam, center_in_cam) - radius * radius);
  return inside < 0 ? 0 : (b - std::sqrt(inside)) / a;
}

TEST(DepthOfMesh, ASphereIsWhereItsEquationSays) {
  const Scene scene = TestScene({"test/r_0"});
  const Camera& camera = scene.cameras[0];
  // The truth is turned, moved and twice as large as the world.
  Similarity3 truth_from_world{
      2, glm::dmat3(glm::angleAxis(0.7, glm::dvec3(0, 0.6, 0.8))), {1, 2, 3}};
  const TriangleMesh sphere = Transformed(TestSphere(200, 1), truth_from_world);
  for (const View& view : scene.views) {
    const MeshDepth depth =
        DepthOfMesh(sphere, truth_from_world, kEverywhere, camera, view.cam_from_world);
    EXPECT_EQ(depth.cut_triangles, 0u);
    const glm::dvec3 center = view.cam_from_world * glm::dvec3(0.0);
    size_t seen = 0;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const double want = SphereDepth(camera, center, 1, x, y);
        // The triangles are inside the sphere by 1 - cos(pi / 400), more at flat angles; a smaller
        // sphere leaves the rim out.
        if (SphereDepth(camera, center, 0.98, x, y) == 0) continue;
        EXPECT_NEAR(double(depth.map.At(x, y)), want, 2e-3) << x << " " << y;
        ++seen;
      }
    }
    EXPECT_GT(seen, 100u);
  }
}

TEST(DepthOfMesh, OnlyPixelsInsideTheBoxAreJudged) {
  const Scene scene = TestScene({"test/r_0"});
  const Bounds3 upper{{-2, -2, 0}, {2, 2, 2}};
  const View& view = scene.views[0];
  const auto draw = [&](const Bounds3& box) {
    return DepthOfMesh(TestSphere(60, 1), {}, box, scene.cameras[0], view.cam_from_world).map;
  };
  const DepthMap all = draw(kEverywhere), half = draw(upper);
  size_t kept = 0, dropped = 0;
  for (int y = 0; y < all.height; ++y) {
    for (int x = 0; x < all.width; ++x) {
      if (all.At(x, y) == kNoDepth) continue;
      const glm::dvec3 point =
          view.cam_from_world.Inverse() *
          (double(all.At(x, y)) * scene.cameras[0].CamFromImage({x + 0.5, y + 0.5}));
      const bool is_kept = half.At(x, y) != kNoDepth;
      EXPECT_EQ(is_kept, point.z >= 0) << point.z;
      ++(is_kept ? kept : dropped);
    }
  }
  EXPECT_GT(kept, 50u);
  EXPECT_GT(dropped, 50u);
}

TEST(DepthOfMesh, TrianglesThatReachBehindTheCameraAreCounted) {
  const TriangleMesh floor{{{-9, 1, -9}, {9, 1, -9}, {0, 1, 9}}, {}, {{0, 1, 2}}};
  const Camera camera{8, 8, 8, 8, 4, 4};
  EXPECT_EQ(DepthOfMesh(floor, {}, kEverywhere, camera, {}).cut_triangles, 1u);
}

// The map of a plane at distance z along the axis, in the data set's encoding, with background on
// the left.
void WriteNerfPlane(const std::filesystem::path& path, const Camera& camera, double z) {
  Image map = MakeImage(camera.width, camera.height, 4);
  for (int y = 0; y < map.height; ++y) {
    for (int x = map.width / 4; x < map.width; ++x) {
      const double distance = z * glm::length(camera.CamFromImage({x + 0.5, y + 0.5}));
      std::fill_n(map.At(x, y), 4, uint8_t(std::lround(255 * (1 - distance / 8))));
    }
  }
  WriteImage(path, map);
}

TEST(NerfDepth, APlaneIsFoundAtItsDepthAtHalfTheSize) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "test");
  WriteNerfPlane(folder / "test/r_1_depth_0001.png", {64, 48, 60, 60, 32, 24}, 4);
  const Camera half{32, 24, 30, 30, 16, 12};
  const DepthMap map = ReadNerfDepth(folder.path(), "test/r_1", half, 0.5);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (x < 8) {
        EXPECT_EQ(map.At(x, y), kNoDepth) << x;
      } else if (x > 8) {
        EXPECT_NEAR(map.At(x, y), 2, 0.5 * 0.5 * 8 / 255 + 1e-6) << x;  // half a step
      }
    }
  }
  ExpectError<DataError>([&] { ReadNerfDepth(folder.path(), "test/r_2", half, 1); },
                         {"r_2_depth_", "test/r_2"});
}

std::optional<DepthScores> DepthScoreOf(const DepthMap& rendered, const DepthMap& truth) {
  DepthErrors errors;
  errors.Add(rendered, truth);
  return std::move(errors).Score(2);
}

TEST(DepthErrors, MissingSurfacesCountAsInfinitelyWrong) {
  DepthMap truth = MakeDepthMap(5, 1), rendered = truth;
  truth.depth = {1, 1, 1, 1, kNoDepth};
  rendered.depth = {1.1f, 0.98f, 1, kNoDepth, 7};
  const auto scores = DepthScoreOf(rendered, truth);
  ASSERT_TRUE(scores);
  EXPECT_EQ(scores->pixels, 4u);  // without the one whose truth is unknown
  EXPECT_EQ(scores->missing, 1u);
  EXPECT_NEAR(scores->median, 0.1, 1e-6);  // of 0, 0.02, 0.1 and infinity, the upper middle
  EXPECT_DOUBLE_EQ(scores->share_within_1_percent, 0.5);  // up to 0.02
  rendered.depth = {1, kNoDepth, kNoDepth, kNoDepth, 7};
  const auto mostly_missing = DepthScoreOf(rendered, truth);
  EXPECT_TRUE(DepthJson(*mostly_missing)["median_error_percent_of_diagonal"].is_null());
  truth.depth.assign(5, kNoDepth);
  EXPECT_FALSE(DepthScoreOf(rendered, truth));
  ExpectError<DataError>([&] { DepthScoreOf(MakeDepthMap(4, 1), truth); }, {"size"});
}

TEST(DepthErrors, ArePooledOverTheViewsThatShowTheTruth) {
  DepthErrors errors;
  DepthMap truth = MakeDepthMap(3, 1), rendered = truth;
  truth.depth = {1, 1, 1};
  rendered.depth = {1, 1.25f, kNoDepth};
  errors.Add(rendered, truth);
  errors.Add(rendered, MakeDepthMap(3, 1));  // the truth is outside of this one's picture
  truth.depth = {2, kNoDepth, 2};
  rendered.depth = {1.5f, 1, 1};
  errors.Add(rendered, truth);
  const auto scores = std::move(errors).Score(2);
  ASSERT_TRUE(scores);
  EXPECT_EQ(scores->views, 2u);
  EXPECT_EQ(scores->pixels, 5u);
  EXPECT_EQ(scores->missing, 1u);
  EXPECT_EQ(scores->median, 0.5);  // of 0, 0.25, 0.5, 1 and infinity
  EXPECT_EQ(scores->share_within_1_percent, 0.2);
}

std::vector<ViewScore> ScoresOf(const std::vector<double>& psnrs) {
  std::vector<ViewScore> scores;
  for (const double psnr : psnrs) {
    scores.emplace_back();
    scores.back().name = fmt::format("view {}", scores.size() - 1);
    scores.back().psnr = psnr;
  }
  return scores;
}

TEST(QualityWarnings, AViewFarBelowTheOthersIsNamed) {
  const auto warnings = QualityWarnings(ScoresOf({28, 27, 13.1, 28.5, 27.5}), {});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("1 of 5 views"));
  EXPECT_THAT(warnings[0], HasSubstr("view 2 (13.1 dB)"));
}

TEST(QualityWarnings, ViewsThatScatterWidelyOrDifferLittleAreNotNamed) {
  EXPECT_TRUE(
      QualityWarnings(ScoresOf({20, 24, 28, 32, 36}), {}).empty());  // 8 dB, but 2 deviations
  EXPECT_TRUE(QualityWarnings(ScoresOf({28, 28, 28, 28, 25.5}), {}).empty());
  EXPECT_TRUE(QualityWarnings(ScoresOf({36, 10}), {}).empty());  // which of two is the bad one?
}

TEST(QualityWarnings, ALowMeanIsStated) {
  const auto warnings = QualityWarnings(ScoresOf({20, 22, 21}), {});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("mean PSNR of only 21.0 dB"));
  EXPECT_TRUE(QualityWarnings(ScoresOf({22, 23}), {}).empty());
  EXPECT_TRUE(QualityWarnings({}, {}).empty());
}

TEST(QualityWarnings, FewTrainingViewsAreStated) {
  const auto warnings = QualityWarnings(ScoresOf({28}), TestScene({"test/r_0"}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("only 8 training views"));
}

}  // namespace
}  // namespace tetrec
