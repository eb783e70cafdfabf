// Structure from motion: what COLMAP may do, and the scene made from its model. Instead of COLMAP a
// stand-in runs that writes the same files.
#include "sfm/sfm.h"

#include "colmap/database.h"
#include "colmap/run.h"
#include "command/stage_command.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/stage.h"
#include "image/exif_block.h"
#include "image/image.h"
#include "paths.h"
#include "scene/scene.h"
#include "scratch_folder.h"
#include "sfm/write_photo.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>
#include <thread>

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

class SfmTest : public ::testing::Test {
 protected:
  struct Outcome {
    int exit_code = 0;
    std::string err;
  };

  // Runs tetrec-sfm as its main function does, with the stand-in for COLMAP first in PATH.
  Outcome Run(const std::string& mode, const SfmOptions& options = {},
              std::vector<std::string> words = {}) {
    const Variable fake("FAKE_COLMAP", mode), calls("FAKE_COLMAP_CALLS", folder_ / "calls.txt");
    const fs::path program = folder_.Write(
        "bin/colmap", fmt::format("#!/bin/sh\nexec '{}' '{}/tests/sfm/fake_colmap.py' \"$@\"\n",
                                  test::Python().string(), test::SourceFolder().string()));
    fs::permissions(program, fs::perms::owner_all);
    const Variable path("PATH", mode == "missing"
                                    ? (folder_ / "empty").string()
                                    : (folder_ / "bin").string() + ":" + std::getenv("PATH"));
    StageCommand command("sfm", 1, "Test.");
    command.InputPath("PHOTOS", "Photos");
    command.InputPath("--masks", "Masks", false);
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

  void WritePhotos(int count) { WriteNumberedPhotos(photos_, count); }

  size_t Calls(const std::string& command) const {
    const std::string text = ReadText(folder_ / "calls.txt");
    size_t count = 0;
    for (size_t at = text.find(command); at != std::string::npos; at = text.find(command, at + 1))
      ++count;
    return count;
  }

  // The notes of the manifest about further tries.
  nlohmann::json Retries() const {
    const std::string text = ReadText(fs::path(scene_) / "manifest.json");
    return nlohmann::json::parse(text)["notes"]["retries"];
  }
  std::string Lens() const {
    const std::string manifest = ReadText(fs::path(scene_) / "manifest.json");
    return nlohmann::json::parse(manifest)["notes"]["lens"];
  }

  ScratchFolder folder_;
  const std::string photos_ = folder_ / "photos", scene_ = folder_ / "run/1_scene";
};

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

TEST_F(SfmTest, PhotosAreTurnedUprightByTheirOrientation) {
  for (int i = 0; i < 12; ++i) {
    Image image = MakeImage(64, 48, 3);  // bright at its top
    std::fill_n(image.pixels.begin(), image.pixels.size() / 2, uint8_t(200 + i));
    const uint32_t orientation = i == 5 ? 1 : i == 7 ? 6 : 3;  // 3: upside down, 6: left is up
    folder_.Write(fmt::format("photos/photo {:02}.jpg", i),
                  WithApp1(EncodeJpeg(image, 95), ExifOfOrientation(orientation)));
  }
  const Outcome outcome = Run("good");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("stored on their side or upside down: 11 of 12;"));
  const Scene scene = ReadScene(scene_);
  // In the model's coordinates, the bottom of most stored images is where z is; one pulls aside.
  constexpr double kPulled = 0.03;
  EXPECT_NEAR(scene.input_from_world.rotation[2].z, -1, kPulled);
  ASSERT_EQ(scene.cameras.size(), 3u);
  const auto down_of = [&](size_t view) {
    return glm::transpose(scene.views[view].cam_from_world.rotation)[1];
  };
  EXPECT_NEAR(down_of(3).z, -1, kPulled);
  EXPECT_NEAR(down_of(5).z, 1, kPulled);
  const auto bright_at_top = [&](size_t view) {
    const Image image = ReadImage(fs::path(scene_) / scene.views[view].image);
    return image.At(8, 8)[0] > image.At(8, 39)[0];
  };
  const Image on_its_side = ReadImage(fs::path(scene_) / scene.views[7].image);
  EXPECT_EQ(on_its_side.width, 48);
  EXPECT_EQ(scene.cameras[size_t(scene.views[7].camera)].width, 48);
  EXPECT_GT(on_its_side.At(40, 30)[0], on_its_side.At(8, 30)[0]) << "bright at its right";
  EXPECT_FALSE(bright_at_top(3));
  EXPECT_TRUE(bright_at_top(5));
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
  WritePhoto(fs::path(photos_) / "photo 05.png", 5);  // another photo: everything is made again
  ASSERT_EQ(Run("good").exit_code, 0);
  EXPECT_EQ(Calls("feature_extractor"), 2 * extractions);
  EXPECT_EQ(Calls("mapper"), 2u);
}

TEST_F(SfmTest, NeighboursAreThoseOfTheUsersOrderWhateverTheSizes) {
  for (int i = 0; i < 40; ++i) {  // every third from another camera
    WritePhoto(fs::path(photos_) / fmt::format("{:02}.png", i), 5 * i, i % 3 == 0 ? 48 : 64);
  }
  SfmOptions options;
  options.matcher = PairChoice::kSequential;
  EXPECT_EQ(Run("none", options).exit_code, 3);
  fs::path database;
  for (const fs::path& path : fs::recursive_directory_iterator(scene_)) {
    if (path.filename() == "sequential.db") database = path;
  }
  const std::vector<DatabaseImage> images = ColmapDatabase(database).Images();
  ASSERT_EQ(images.size(), 40u);
  for (size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(fs::path(images[i].name).stem(), fmt::format("{:02}", i));
  }
  const std::set<ImagePair> pairs = ColmapDatabase(database).MatchedPairs();
  for (uint32_t id = 1; id < 40; ++id) EXPECT_TRUE(pairs.contains({id, id + 1})) << id;
}

TEST_F(SfmTest, WhatColmapCallsSuccessIsJudged) {
  WritePhotos(12);
  Outcome outcome = Run("none");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("do not overlap"));
  outcome = Run("junk", {}, {"--force"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("only 2 of 12 photos"));
  EXPECT_THAT(outcome.err, HasSubstr("photo 02.png"));
  outcome = Run("half", {}, {"--force"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("only 6 of 12 photos"));
  EXPECT_FALSE(fs::exists(fs::path(scene_) / "manifest.json"));
  EXPECT_FALSE(fs::exists(fs::path(scene_) / "scene.json"));
}

TEST_F(SfmTest, PhotosThatStayOutAreTriedAgainWithMoreFeatures) {
  WritePhotos(12);
  const Outcome outcome = Run("late");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(ReadScene(scene_).views.size(), 12u);
  EXPECT_EQ(Calls("mapper"), 2u);
  ASSERT_EQ(Retries().size(), 1u);
  const nlohmann::json retry = Retries().at(0);
  EXPECT_EQ(retry["max_features"], 8192);
  EXPECT_EQ(retry["registered_before"], 10);
  EXPECT_EQ(retry["registered"], 12);
  EXPECT_EQ(retry["kept"], true);
  // Another size takes everything from the cache.
  ASSERT_EQ(Run("late", {}, {"--max-size", "16"}).exit_code, 0);
  EXPECT_EQ(Calls("mapper"), 2u);
  EXPECT_EQ(ReadScene(scene_).views.size(), 12u);
}

TEST_F(SfmTest, ATryThatRegistersNoMorePhotosChangesNothing) {
  WritePhotos(12);
  ASSERT_EQ(Run("never").exit_code, 0);
  EXPECT_EQ(ReadScene(scene_).views.size(), 10u);
  EXPECT_EQ(Calls("mapper"), 2u);
  const nlohmann::json manifest =
      nlohmann::json::parse(ReadText(fs::path(scene_) / "manifest.json"));
  EXPECT_EQ(manifest["notes"]["retries"][0]["kept"], false);
  EXPECT_EQ(manifest["notes"]["unregistered"].size(), 2u);
}

TEST_F(SfmTest, WhereManyPhotosStayOutTheMapperDemandsFewerInliers) {
  WritePhotos(12);
  const Outcome outcome = Run("wide");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Calls("mapper"), 3u);
  ASSERT_EQ(Retries().size(), 2u);
  const nlohmann::json retry = Retries().at(1);
  EXPECT_EQ(retry["image_inliers"], kMildDemands.image_inliers);
  EXPECT_EQ(retry["registered_before"], 6);
  EXPECT_EQ(retry["registered"], 12);
  // Another size takes everything from the cache.
  ASSERT_EQ(Run("wide", {}, {"--max-size", "16"}).exit_code, 0);
  EXPECT_EQ(Calls("mapper"), 3u);
}

TEST_F(SfmTest, NothingIsTriedAgainIfAllAreRegisteredOrItIsSwitchedOff) {
  WritePhotos(12);
  ASSERT_EQ(Run("good").exit_code, 0);
  EXPECT_EQ(Calls("mapper"), 1u);
  SfmOptions options;
  options.retries = 0;
  ASSERT_EQ(Run("never", options, {"--force"}).exit_code, 0);
  EXPECT_EQ(Calls("mapper"), 2u);
  EXPECT_EQ(ReadScene(scene_).views.size(), 10u);
}

TEST_F(SfmTest, AnUnreadablePhotoIsLeftOutAndRecorded) {
  WritePhotos(12);
  folder_.Write("photos/letter.jpg", "this is a text");
  SfmOptions options;
  options.max_unreadable = 0;
  const Outcome strict = Run("good", options);
  EXPECT_EQ(strict.exit_code, 3);
  EXPECT_THAT(strict.err, HasSubstr("1 of 13 photos cannot be read"));
  const Outcome outcome = Run("good");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(ReadScene(scene_).views.size(), 12u);
  const nlohmann::json manifest =
      nlohmann::json::parse(ReadText(fs::path(scene_) / "manifest.json"));
  EXPECT_EQ(manifest["counts"]["photos"], 12);
  EXPECT_EQ(manifest["counts"]["unreadable"], 1);
  EXPECT_EQ(manifest["notes"]["unreadable"][0], "letter.jpg");
  EXPECT_EQ(manifest["warnings"].size(), 1u);
}

TEST_F(SfmTest, MasksReachColmapAndTheScene) {
  WritePhotos(12);
  // In a folder inside that of the photos, which takes no part as photos.
  const fs::path masks = fs::path(photos_) / "masks";
  for (int i = 0; i < 12; ++i) {
    Image mask = MakeImage(64, 48, 3);
    for (int x = 32; x < 64; ++x) {
      for (int y = 0; y < 48; ++y) std::fill_n(mask.At(x, y), 3, 255);
    }
    fs::create_directories(masks);
    WriteImage(masks / fmt::format("photo {:02}.png.png", i), i == 5 ? MakeImage(64, 48, 3) : mask);
  }
  const Outcome outcome = Run("good", {}, {"--masks", masks.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("masks exclude 54.2 % of all pixels"));
  const Scene scene = ReadScene(scene_);
  ASSERT_EQ(scene.views.size(), 11u);
  EXPECT_TRUE(scene.has_masks);
  EXPECT_FALSE(scene.has_alpha);
  const Image picture = ReadImage(fs::path(scene_) / scene.views[0].image);
  ASSERT_EQ(picture.channels, 4);
  EXPECT_EQ(picture.At(20, 9)[3], 0);
  EXPECT_EQ(picture.At(40, 9)[3], 255);
  EXPECT_EQ(picture.At(40, 9)[0], 40);
  const nlohmann::json manifest =
      nlohmann::json::parse(ReadText(fs::path(scene_) / "manifest.json"));
  EXPECT_EQ(manifest["notes"]["hidden_by_masks"][0], "photo 05.png");
  // Another mask: the features are found again. All photos without masks: so are they.
  const size_t extractions = Calls("feature_extractor");
  WriteImage(masks / "photo 00.png.png",
             Image{64, 48, 3, std::vector<uint8_t>(size_t(64) * 48 * 3, 255)});
  ASSERT_EQ(Run("good", {}, {"--masks", masks.string()}).exit_code, 0);
  EXPECT_EQ(Calls("feature_extractor"), 2 * extractions);
  EXPECT_EQ(ReadImage(fs::path(scene_) / "images/photo 00.png").At(20, 9)[3], 255);
}

TEST_F(SfmTest, GivenBoundsAreThoseOfTheWorldThatIsFound) {
  WritePhotos(12);
  SfmOptions options;
  options.bounds_in_found_world = {glm::dvec3(-0.5), glm::dvec3(1.5)};
  const Outcome outcome = Run("good", options);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("of 300 points are inside"));
  const Scene scene = ReadScene(scene_);
  EXPECT_NEAR(scene.subject_bounds.max.z, 1, 1e-12);
  // The middle of the ball of points, which was at 0, is half a unit from the box's middle.
  EXPECT_NEAR(glm::distance(scene.input_from_world.Inverse() * glm::dvec3(0), glm::dvec3(-0.5)), 0,
              0.03);
  options.bounds_in_found_world = {glm::dvec3(5), glm::dvec3(6)};
  const Outcome empty = Run("good", options, {"--force"});
  EXPECT_EQ(empty.exit_code, 3);
  EXPECT_THAT(empty.err, HasSubstr("the given bounds contain none of the points"));
}

TEST_F(SfmTest, TheErrorOfAnEarlierAttemptIsNotPrintedAgain) {
  WritePhotos(12);
  ASSERT_THAT(Run("killed").err, HasSubstr("signal 9"));
  const Outcome outcome = Run("good");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("continues an earlier run (failed)"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("signal 9")));
}

// COLMAP's extractor runs once on each core, for a part of the photos.
size_t ExtractorsOf(size_t photos) {
  return std::min(photos, size_t{std::max(1u, std::thread::hardware_concurrency())});
}

TEST_F(SfmTest, ALensThatFoldsOverIsReplacedByASimplerOne) {
  WritePhotos(12);
  const Outcome outcome = Run("bent");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Calls("mapper"), 2u);
  EXPECT_EQ(Calls("feature_extractor"), ExtractorsOf(12)) << "features are found once";
  EXPECT_THAT(outcome.err, HasSubstr("folds over; trying again with SIMPLE_RADIAL"));
  EXPECT_EQ(Lens(), "SIMPLE_RADIAL");
}

TEST_F(SfmTest, FurtherTriesOfLensesThatLeaveOutTheSamePhotosShareTheirFeatures) {
  WritePhotos(12);
  const Outcome outcome = Run("leaving");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Lens(), "SIMPLE_RADIAL");
  EXPECT_EQ(Calls("mapper"), 4u) << "each lens twice";
  EXPECT_EQ(Calls("lenses SIMPLE_RADIAL\n"), 2u);
  const size_t concerned = 5;  // the last two, and three neighbours before them
  EXPECT_EQ(Calls("feature_extractor"), ExtractorsOf(12) + ExtractorsOf(concerned));
}

TEST_F(SfmTest, ASimplerLensIsTakenThatRegistersEnoughPhotos) {
  WritePhotos(12);
  const Outcome outcome = Run("narrow");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(ReadScene(scene_).views.size(), 12u);
  EXPECT_EQ(Lens(), "SIMPLE_RADIAL");
  EXPECT_THAT(ReadText(fs::path(scene_) / "log.txt"),
              HasSubstr("only 6 of 12 photos are registered; trying again with SIMPLE_RADIAL"));
}

TEST_F(SfmTest, EachCameraGetsTheLensThatItsPhotosDetermine) {
  for (int i = 0; i < 11; ++i) {
    WritePhoto(fs::path(photos_) / fmt::format("{}/{:02}.png", i < 8 ? "many" : "few", i), 9 * i);
  }
  SfmOptions options;
  options.camera_sharing = CameraSharing::kPerFolder;
  ASSERT_EQ(Run("good", options).exit_code, 0);
  EXPECT_EQ(Calls("lenses SIMPLE_RADIAL OPENCV\n"), 1u) << "the few are first by name";
  EXPECT_EQ(Lens(), "OPENCV, of cameras with fewer than 8 photos SIMPLE_RADIAL: 1");
  options.camera_model = SfmLens::kOpenCv;
  ASSERT_EQ(Run("good", options, {"--max-size", "32"}).exit_code, 0);
  EXPECT_EQ(Calls("lenses OPENCV OPENCV\n"), 1u) << "as asked for, not from the cache";
  EXPECT_EQ(Lens(), "OPENCV");
}

TEST_F(SfmTest, PhotosThatWereZoomedDigitallyHaveACameraOfTheirOwn) {
  for (int i = 0; i < 12; ++i) {
    const Image image{64, 48, 3, std::vector<uint8_t>(size_t(64) * 48 * 3, uint8_t(40 + 10 * i))};
    folder_.Write(fmt::format("photos/{:02}.jpg", i),
                  WithApp1(EncodeJpeg(image, 95), ExifOfDigitalZoom(i % 3 == 0 ? 2 : 1, 1)));
  }
  ASSERT_EQ(Run("good").exit_code, 0);
  EXPECT_EQ(Calls("lenses SIMPLE_RADIAL OPENCV\n"), 1u) << "the four zoomed ones are first by name";
  EXPECT_THAT(ReadText(fs::path(scene_) / "log.txt"), HasSubstr("12 photos of 2 cameras"));
}

TEST_F(SfmTest, ALensOfOblongPixelsIsReplacedByASimplerOneThatFitsAsWell) {
  WritePhotos(12);
  const Outcome outcome = Run("oblong");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Calls("mapper"), 2u);
  EXPECT_THAT(outcome.err, HasSubstr("a pixel would be 1.200 times as wide as it is high; trying "
                                     "again with SIMPLE_RADIAL"));
  EXPECT_EQ(Lens(), "SIMPLE_RADIAL");
  const Camera camera = ReadScene(scene_).cameras[0];
  EXPECT_NEAR(camera.fx, camera.fy, 1e-9);
  SfmOptions options;
  options.holdout = 4;
  ASSERT_EQ(Run("oblong", options).exit_code, 0);
  EXPECT_EQ(Calls("mapper"), 2u) << "both models come from the cache";
  EXPECT_EQ(Lens(), "SIMPLE_RADIAL");
}

TEST_F(SfmTest, ALensOfOblongPixelsStaysIfSimplerOnesFitWorse) {
  WritePhotos(12);
  const Outcome outcome = Run("anamorphic");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Calls("mapper"), 2u);
  EXPECT_THAT(outcome.err, HasSubstr("not taken"));
  EXPECT_EQ(Lens(), "OPENCV");
  const Camera camera = ReadScene(scene_).cameras[0];
  EXPECT_NEAR(camera.fy / camera.fx, 1.2, 0.02);
}

TEST_F(SfmTest, ALensThatWasAskedForIsNotReplaced) {
  WritePhotos(12);
  SfmOptions options;
  options.camera_model = SfmLens::kOpenCv;
  const Outcome outcome = Run("bent", options);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err,
              HasSubstr("; try camera model SIMPLE_RADIAL or SIMPLE_PINHOLE, or auto"));
  EXPECT_EQ(Calls("mapper"), 1u);
}

TEST_F(SfmTest, LensesThatAllFoldOverAreNamedWithAPhotoAndAdvice) {
  WritePhotos(12);
  const Outcome outcome = Run("folded");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(Calls("mapper"), 3u);
  EXPECT_THAT(outcome.err, HasSubstr("photo 00.png (lens SIMPLE_RADIAL): the lens distortion"));
  EXPECT_THAT(outcome.err,
              HasSubstr("; try camera model SIMPLE_RADIAL or SIMPLE_PINHOLE, or auto"));
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

TEST_F(SfmTest, WhatAnotherVersionOfColmapDoesNotAcceptNamesBothVersions) {
  WritePhotos(3);
  const auto expect = [&](const std::string& mode, const std::string& version,
                          const std::string& what) {
    const Outcome outcome = Run(mode, {}, {"--force"});
    EXPECT_EQ(outcome.exit_code, 4) << mode;
    EXPECT_THAT(outcome.err, HasSubstr(what)) << mode;
    EXPECT_THAT(outcome.err, HasSubstr("COLMAP " + version +
                                       " was found, 3.8 is the tested version: install that one"))
        << mode;
    EXPECT_THAT(outcome.err, Not(HasSubstr("force a fresh run"))) << mode;
  };
  for (const std::string command : {"feature_extractor", "matches_importer", "mapper"}) {
    expect("renamed " + command, "4.0.1",
           "colmap " + command +
               ": it does not accept our options (E0101 option_manager.cc:9] "
               "Failed to parse options - unrecognised option '--");
    expect("unknown " + command, "4.0.1", "colmap " + command + ": it does not know this command");
  }
  expect("idle feature_extractor", "4.0.1", "feature_extractor wrote no database");
  expect("idle matches_importer", "4.0.1", "matches_importer did not verify all pairs");
  expect("rigs", "3.12.0", "frames, which Tetrec cannot renumber");
}

}  // namespace
}  // namespace tetrec
