// Structure from motion: photos that cannot be used, what COLMAP may do, the subject's bounds.
// COLMAP itself is not run here but a stand-in that writes the same files.
#include "scene/sfm.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "scene/image.h"
#include "scene/sfm_bounds.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

// An environment variable for the length of a test.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

void WritePhoto(const fs::path& path, int shade, int width = 64) {
  fs::create_directories(path.parent_path());
  Image image{width, 48, 3, std::vector<uint8_t>(size_t(width) * 48 * 3, uint8_t(shade))};
  WriteImage(path, image);
}

class SfmTest : public ::testing::Test {
 protected:
  struct Outcome {
    int exit_code = 0;
    std::string err;
  };

  // tetrec-sfm as its main does it, with the stand-in for COLMAP first in PATH.
  Outcome Run(const std::string& mode, const SfmOptions& options = {},
              std::vector<std::string> words = {}) {
    const Variable fake("FAKE_COLMAP", mode), calls("FAKE_COLMAP_CALLS", folder_ / "calls.txt");
    const fs::path program = folder_.Write(
        "bin/colmap",
        fmt::format("#!/bin/sh\nexec python3 '{}/tests/scene/fake_colmap.py' \"$@\"\n",
                    TETREC_SOURCE_DIR));
    fs::permissions(program, fs::perms::owner_all);
    const Variable path("PATH", mode == "missing"
                                    ? (folder_ / "empty").string()
                                    : (folder_ / "bin").string() + ":" + std::getenv("PATH"));
    StageCommand command("sfm", 1, "Test.");
    command.InputPath("PHOTOS", "Photos");
    SfmOptions copy = options;
    command.app().add_option("--max-size", copy.max_size, "");
    command.app().add_option("--holdout", copy.holdout, "");
    words.insert(words.begin(), {"tetrec-sfm", photos_, "-o", scene_});
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    Outcome outcome;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    outcome.exit_code =
        command.Run(int(argv.size()), argv.data(), [&](Stage& stage) { RunSfm(copy, stage); });
    ::testing::internal::GetCapturedStdout();
    outcome.err = ::testing::internal::GetCapturedStderr();
    SetLogFile("");
    TakeWarnings();
    return outcome;
  }

  void WritePhotos(int count) {
    for (int i = 0; i < count; ++i)
      WritePhoto(fs::path(photos_) / fmt::format("photo {:02}.png", i), 10 * i + 40);
  }

  size_t Calls(const std::string& command) const {
    const std::string text = ReadText(folder_ / "calls.txt");
    size_t count = 0;
    for (size_t at = text.find(command); at != std::string::npos; at = text.find(command, at + 1))
      ++count;
    return count;
  }

  ScratchFolder folder_;
  const std::string photos_ = folder_ / "photos", scene_ = folder_ / "run/1_scene";
};

TEST_F(SfmTest, FoldersWithoutPhotosOrWithOneAreRefused) {
  ExpectError<DataError>([&] { FindPhotos(photos_); }, {"is no folder"});
  fs::create_directories(photos_);
  folder_.Write("photos/readme.txt", "no photo");
  folder_.Write("photos/.hidden.jpg", "no photo");
  ExpectError<DataError>([&] { FindPhotos(photos_); }, {"holds no photos"});
  WritePhotos(1);
  ExpectError<DataError>([&] { FindPhotos(photos_); }, {"only one photo", "photo 00.png"});
}

TEST_F(SfmTest, PicturesOfOtherKindsAreNamed) {
  WritePhotos(1);
  folder_.Write("photos/b.HEIC", "of a phone");
  folder_.Write("photos/notes.txt", "no photo");
  TakeWarnings();
  ExpectError<DataError>([&] { FindPhotos(photos_); }, {"only one photo"});
  EXPECT_THAT(TakeWarnings(), ::testing::ElementsAre(::testing::AllOf(
                                  ::testing::HasSubstr("left out: 1: b.HEIC; convert"),
                                  ::testing::Not(::testing::HasSubstr("notes")))));
}

TEST_F(SfmTest, AllPhotosThatCannotBeReadAreNamedAtOnce) {
  WritePhotos(3);
  folder_.Write("photos/letter.jpg", "this is a text");
  folder_.Write("photos/empty.png", "");
  const std::vector<uint8_t> whole = ReadBytes(fs::path(photos_) / "photo 00.png");
  folder_.Write("photos/cut.png", std::span(whole).first(whole.size() / 2));
  ExpectError<DataError>([&] { FindPhotos(photos_); },
                         {"3 of 6", "letter.jpg", "empty.png", "cut.png"});
}

TEST_F(SfmTest, PhotosAreFoundInFoldersAndSortedByName) {
  WritePhoto(fs::path(photos_) / "b/2.png", 10);
  WritePhoto(fs::path(photos_) / "b/1.PNG", 20);
  WritePhoto(fs::path(photos_) / "a.jpg", 30, 32);
  const std::vector<Photo> photos = FindPhotos(photos_);
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[0].name, "a.jpg");
  EXPECT_EQ(photos[0].width, 32);
  EXPECT_EQ(photos[1].name, "b/1.PNG");
  EXPECT_EQ(photos[2].name, "b/2.png");
}

TEST_F(SfmTest, AGoodModelBecomesAScene) {
  WritePhotos(12);
  SfmOptions options;
  options.max_size = 32;
  const Outcome outcome = Run("good", options);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Scene scene = ReadScene(scene_);
  ASSERT_EQ(scene.views.size(), 12u);
  EXPECT_EQ(scene.views[3].name, "photo 03.png");
  EXPECT_EQ(scene.ViewsOf(Split::kTest), (std::vector<int>{0, 8}));
  EXPECT_EQ(scene.cameras[0].width, 32);
  EXPECT_EQ(scene.cameras[0].height, 24);
  EXPECT_NEAR(scene.cameras[0].fx, 40, 1e-6);
  const Image picture = ReadImage(fs::path(scene_) / scene.views[3].image);
  EXPECT_EQ(picture.width, 32);
  EXPECT_EQ(picture.At(5, 5)[0], 70);  // each photo has one shade
  EXPECT_EQ(scene.points.size(), 300u);
  // The subject is a unit ball: centre and radius come back within the trimming of 1 % of the
  // points (0.02 of the radius) and the margin of 5 %.
  EXPECT_NEAR(scene.input_from_world.scale, 1.1 * 0.98, 0.03);
  EXPECT_NEAR(glm::length(scene.input_from_world.translation), 0, 0.03);
  for (const View& view : scene.views) {
    const glm::dvec3 center = view.cam_from_world.Inverse().translation;
    EXPECT_NEAR(glm::length(scene.input_from_world * center), 4, 1e-9);
  }
}

TEST_F(SfmTest, OtherSizesAndSplitsReuseFeaturesMatchesAndModel) {
  WritePhotos(12);
  ASSERT_EQ(Run("good").exit_code, 0);
  const size_t extractions = Calls("feature_extractor");
  const Outcome again = Run("good", {}, {"--max-size", "16", "--holdout", "0"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(Calls("feature_extractor"), extractions);
  EXPECT_EQ(Calls("mapper"), 1u);
  EXPECT_EQ(ReadScene(scene_).cameras[0].width, 16);
  EXPECT_TRUE(ReadScene(scene_).ViewsOf(Split::kTest).empty());
  WritePhoto(fs::path(photos_) / "photo 05.png", 5);  // another picture: all anew
  ASSERT_EQ(Run("good").exit_code, 0);
  EXPECT_EQ(Calls("feature_extractor"), 2 * extractions);
  EXPECT_EQ(Calls("mapper"), 2u);
}

TEST_F(SfmTest, WhatColmapCallsSuccessIsJudged) {
  WritePhotos(12);
  Outcome outcome = Run("none");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("do not overlap"));
  outcome = Run("junk", {}, {"--force"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("only 2 of 12 pictures"));
  EXPECT_THAT(outcome.err, HasSubstr("photo 02.png"));
  outcome = Run("half", {}, {"--force"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("only 6 of 12 pictures"));
  EXPECT_FALSE(fs::exists(fs::path(scene_) / "manifest.json"));
  EXPECT_FALSE(fs::exists(fs::path(scene_) / "scene.json"));
}

TEST_F(SfmTest, ALensThatFoldsOverIsNamedWithAPhotoAndAdvice) {
  WritePhotos(12);
  const Outcome outcome = Run("folded");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("photo 00.png (lens SIMPLE_RADIAL): the lens distortion"));
  EXPECT_THAT(outcome.err, HasSubstr("; try --camera-model SIMPLE_RADIAL or PINHOLE"));
}

TEST_F(SfmTest, AMissingColmapAFullDiskAndAKilledColmapAreEnvironmentErrors) {
  WritePhotos(3);
  Outcome outcome = Run("missing");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("apt-get install colmap"));
  outcome = Run("full");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("the disk is full"));
  outcome = Run("killed", {}, {"--force"});
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("signal 9"));
}

TEST_F(SfmTest, AnotherVersionOfColmapIsUsedWithOneWarning) {
  WritePhotos(12);
  const auto warnings = [&] {
    const nlohmann::json manifest =
        nlohmann::json::parse(ReadText(fs::path(scene_) / "manifest.json"));
    size_t count = 0;
    for (const std::string warning : manifest["warnings"])
      count += warning.find("COLMAP 3.11.1 was not tested with Tetrec; 3.8 was") == 0;
    return count;
  };
  Outcome outcome = Run("newer");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(warnings(), 1u);
  EXPECT_EQ(ReadScene(scene_).views.size(), 12u);
  outcome = Run("good", {}, {"--force"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(warnings(), 0u);
  EXPECT_THAT(outcome.err, Not(HasSubstr("not tested")));
}

TEST_F(SfmTest, WhatAnotherVersionOfColmapDoesNotTakeNamesBothVersions) {
  WritePhotos(3);
  const auto expect = [&](const std::string& mode, const std::string& version,
                          const std::string& what) {
    const Outcome outcome = Run(mode, {}, {"--force"});
    EXPECT_EQ(outcome.exit_code, 4) << mode;
    EXPECT_THAT(outcome.err, HasSubstr(what)) << mode;
    EXPECT_THAT(outcome.err, HasSubstr("COLMAP " + version +
                                       " was found, 3.8 is the tested version: install that one"))
        << mode;
    EXPECT_THAT(outcome.err, Not(HasSubstr("again with --force"))) << mode;
  };
  for (const std::string command : {"feature_extractor", "matches_importer", "mapper"}) {
    expect("renamed " + command, "4.0.1",
           "colmap " + command +
               ": it does not take our options (E0101 option_manager.cc:9] "
               "Failed to parse options - unrecognised option '--");
    expect("unknown " + command, "4.0.1", "colmap " + command + ": it does not know this command");
  }
  expect("idle feature_extractor", "4.0.1", "feature_extractor wrote no database");
  expect("idle matches_importer", "4.0.1", "matches_importer did not verify all pairs");
  expect("rigs", "3.12.0", "frames, which Tetrec does not number anew");
}

TEST_F(SfmTest, OptionsOutOfRangeAreUsageErrors) {
  const auto message = [](auto change) {
    SfmOptions options;
    change(options);
    ExpectError<UsageError>([&] { CheckSfmOptions(options); }, {"--"});
  };
  EXPECT_NO_THROW(CheckSfmOptions({}));
  message([](SfmOptions& o) { o.matcher = "best"; });
  message([](SfmOptions& o) { o.camera_sharing = "all"; });
  message([](SfmOptions& o) { o.camera_model = "FISHEYE"; });
  message([](SfmOptions& o) { o.max_size = 0; });
  message([](SfmOptions& o) { o.max_features = -1; });
  message([](SfmOptions& o) { o.holdout = 1; });
}

ColmapModel ModelOf(size_t images, size_t points, double error_px, size_t track_length) {
  ColmapModel model;
  model.cameras[1] = {1, 1600, 1200, {1000, 1000, 800, 600}};
  for (uint32_t i = 0; i < images; ++i) model.images[i].name = fmt::format("{}.jpg", i);
  for (uint64_t i = 0; i < points; ++i) {
    model.points[i].error_px = error_px;
    model.points[i].track.resize(track_length);
  }
  return model;
}

TEST(JudgeModel, EachLimitIsAppliedAndNamed) {
  std::vector<std::string> names;
  for (int i = 0; i < 50; ++i) names.push_back(fmt::format("{}.jpg", i));
  EXPECT_EQ(JudgeModel(ModelOf(40, 100, 1.5, 3), names).registered, 40u);
  ExpectError<DataError>([&] { JudgeModel(ModelOf(39, 100, 1, 3), names); },
                         {"39 of 50", "39.jpg", "1 more"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 99, 1, 3), names); }, {"99 points"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 100, 1.6, 3), names); }, {"1.60 px"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 100, 1, 2), names); }, {"2.00 pictures"});
  ColmapModel large = ModelOf(50, 100, 1.6, 3);  // the same error in a photo of twice the size
  large.cameras[1].width = 3200;
  EXPECT_NO_THROW(JudgeModel(large, names));
}

// The room: a ball in the middle, walls at 4, seen from around.
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

TEST(Subject, TheBallIsToldFromTheWallsBehindIt) {
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
  EXPECT_GT(double(inside),
            0.97 * double(ball));  // 1 % is trimmed at each end, the margin wins most back
  EXPECT_EQ(walls_inside, 0u);
  const glm::dvec3 size = subject.bounds_in_world.Size();
  EXPECT_NEAR(std::max({size.x, size.y, size.z}), 2, 1e-12);
  EXPECT_NEAR(glm::length(subject.bounds_in_world.Center()), 0, 1e-12);
}

TEST(Subject, DoesNotDependOnTheFrameThatTheCamerasCameIn) {
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
    EXPECT_NEAR(glm::distance(a, b), 0,
                1e-6);  // rounding of the least squares, scaled up by 1 / 0.037
  }
  for (size_t i = 0; i < room.points.size(); i += 100) {
    EXPECT_NEAR(glm::distance(still.points[i].position, moved.points[i].position), 0, 1e-6);
  }
  // And the way back leads to the frame that was given.
  EXPECT_NEAR(glm::distance(moved.input_from_world * moved.points[0].position,
                            other_from_room * room.points[0].position),
              0, 1e-9);
}

// The pictures must not change: every point stays on its pixel, in front of the camera.
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
  EXPECT_GT(FindUp(views).z,
            std::cos(5.0 / 180 * M_PI));  // the trust in the mean costs some degrees
}

}  // namespace
}  // namespace tetrec
