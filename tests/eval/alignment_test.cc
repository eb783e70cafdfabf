#include "eval/alignment.h"

#include "core/error.h"
#include "eval/fake_run.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace tetrec {
namespace {

Similarity3 SomeSimilarity(double scale, double turn, const glm::dvec3& translation) {
  Similarity3 similarity;
  similarity.scale = scale;
  similarity.rotation =
      glm::dmat3(glm::mat3_cast(glm::angleAxis(turn, glm::normalize(glm::dvec3(0.3, -0.8, 0.52)))));
  similarity.translation = translation;
  return similarity;
}

void ExpectSame(const Similarity3& a, const Similarity3& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance * b.scale);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(a.translation[i], b.translation[i], tolerance * (1 + glm::length(b.translation)));
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(a.rotation[i][j], b.rotation[i][j], tolerance);
  }
}

std::vector<TrueCamera> MovedCameras(const Scene& scene, const Similarity3& truth_from_input) {
  std::vector<TrueCamera> cameras;
  for (const View& view : scene.views) {
    TrueCamera camera;
    camera.file = "photos/" + view.name + ".jpg";
    const Similarity3 truth_from_world = truth_from_input * scene.input_from_world;
    const glm::dvec3 center = truth_from_world * view.cam_from_world.Inverse().translation;
    camera.cam_from_truth.rotation =
        view.cam_from_world.rotation * glm::transpose(truth_from_world.rotation);
    camera.cam_from_truth.translation = -(camera.cam_from_truth.rotation * center);
    cameras.push_back(camera);
  }
  return cameras;
}

RC_GTEST_PROP(Alignment, AKnownSimilarityIsRecovered, ()) {
  const auto number = [](int low, int high) {
    return *rc::gen::inRange(low * 1000, high * 1000) / 1000.0;
  };
  const Similarity3 known =
      SomeSimilarity(number(1, 50), number(-3, 3), {number(-9, 9), number(-9, 9), number(-9, 9)});
  std::vector<glm::dvec3> from = {{0, 0, 0}, {1, 0.2, 0}, {0.1, 1, 0.3}}, to;
  for (int i = 0; i < 7; ++i) from.emplace_back(number(-2, 2), number(-2, 2), number(-2, 2));
  for (const glm::dvec3& point : from) to.push_back(known * point);
  const Similarity3 found = FitSimilarity(from, to);
  // Double precision on values up to about 100.
  for (size_t i = 0; i < from.size(); ++i) RC_ASSERT(glm::length(found * from[i] - to[i]) < 1e-9);
  RC_ASSERT(std::abs(found.scale - known.scale) < 1e-9 * known.scale);
}

TEST(Alignment, CamerasOfAPlaneRecoverTheSimilarityWithoutMirroring) {
  const Similarity3 known = SomeSimilarity(0.25, 2.5, {4, -2, 1});
  const std::vector<glm::dvec3> from = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {3, 1, 0}};
  std::vector<glm::dvec3> to;
  for (const glm::dvec3& point : from) to.push_back(known * point);
  ExpectSame(FitSimilarity(from, to), known, 1e-9);
}

TEST(Alignment, CamerasOnALineOrTooFewAreRefused) {
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  ExpectError<DataError>([&] { FitSimilarity(line, line); }, {"one line"});
  const std::vector<glm::dvec3> same(5, glm::dvec3(1, 2, 3));
  ExpectError<DataError>([&] { FitSimilarity(same, same); }, {"one point"});
  ExpectError<DataError>([&] { FitSimilarity(std::span(line).first(2), std::span(line).first(2)); },
                         {"3 or more pairs of points, got 2 and 2"});
}

TEST(Alignment, GoesFromWorldThroughTheInputToTheTruth) {
  Scene scene = TestScene({"test/r_0"});
  scene.input_from_world = SomeSimilarity(3, 0.7, {1, 2, 3});
  const Similarity3 known = SomeSimilarity(0.5, -1.1, {-2, 0, 7});
  const Alignment alignment = AlignByCameras(scene, MovedCameras(scene, known));
  ExpectSame(alignment.truth_from_input, known, 1e-9);
  EXPECT_EQ(alignment.matched, scene.views.size());
  EXPECT_TRUE(alignment.unmatched.empty());
  EXPECT_LT(alignment.center_max, 1e-9);
  // acos near 1 halves the digits.
  EXPECT_LT(alignment.rotation_max_deg, 1e-5);
}

TEST(Alignment, ResidualsRevealAMisplacedCamera) {
  const Scene scene = TestScene({});
  std::vector<TrueCamera> cameras = MovedCameras(scene, {});
  cameras[0].cam_from_truth.translation += glm::dvec3(0.1, 0, 0);
  const Alignment alignment = AlignByCameras(scene, cameras);
  EXPECT_GT(alignment.center_max, 0.05);
  EXPECT_LT(alignment.center_max, 0.1);  // a least-squares fit shares the error out
  EXPECT_LT(alignment.center_rms, alignment.center_max);
  EXPECT_GT(alignment.rotation_max_deg, 0.1);
}

TEST(Alignment, ViewsMatchByImageNameAndUnmatchedOnesAreNamed) {
  Scene scene = TestScene({});
  std::vector<TrueCamera> cameras = MovedCameras(scene, {});
  cameras.pop_back();
  scene.views[0].name = "r_0.png";  // "photos/train/r_0.jpg" ends in it
  const Alignment alignment = AlignByCameras(scene, cameras);
  EXPECT_EQ(alignment.matched, 7u);
  EXPECT_EQ(alignment.unmatched, std::vector<std::string>{"train/r_7"});

  cameras[1].file = "other/r_0.png";
  ExpectError<DataError>([&] { AlignByCameras(scene, cameras); }, {"'r_0.png'", "other/r_0.png"});
  scene.views[0].name = "other/r_0.png";  // the same name counts before its tail
  cameras[0].file = "r_0.png";
  EXPECT_EQ(AlignByCameras(scene, cameras).matched, 6u);
  ExpectError<DataError>([&] { AlignByCameras(scene, std::span(cameras).last(2)); },
                         {"of 8 views"});
}

TEST(Alignment, WhatFollowsADotInANameTellsFramesApart) {
  Scene scene = TestScene({});
  std::vector<TrueCamera> cameras = MovedCameras(scene, {});
  for (size_t i = 0; i < scene.views.size(); ++i) {
    scene.views[i].name = fmt::format("frame.{:04}", i);
    cameras[i].file = fmt::format("photos/frame.{:04}.jpg", i);
  }
  EXPECT_EQ(AlignByCameras(scene, cameras).matched, scene.views.size());
}

TEST(Alignment, TrueCamerasAreReadAndBadOnesNamed) {
  const ScratchFolder folder;
  const auto read = [&](const std::string& pose) {
    return ReadTrueCameras(folder.Write(
        "cameras.json",
        R"({"frames": [{"file": "photos/0001.jpg", "cam_from_world": )" + pose + "}]}"));
  };
  const auto cameras = read("[[0, -1, 0, 4], [1, 0, 0, 5], [0, 0, 1, 6]]");
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].file, "photos/0001.jpg");
  EXPECT_EQ(cameras[0].cam_from_truth * glm::dvec3(1, 0, 0), glm::dvec3(4, 6, 6));
  ExpectError<DataError>([&] { read("[[1, 0, 0, 0], [0, 1, 0, 0]]"); },
                         {"frames[0].cam_from_world has 2 rows; expected 3"});
  ExpectError<DataError>([&] { read("[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"); },
                         {"frames[0].cam_from_world[0] has 3 numbers; expected 4"});
  ExpectError<DataError>([&] { read("[[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0]]"); },
                         {"not a rotation"});
  ExpectError<DataError>([&] { read("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]"); },
                         {"not a rotation"});
}

}  // namespace
}  // namespace tetrec
