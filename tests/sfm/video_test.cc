#include "sfm/video.h"

#include "core/child_process.h"
#include "core/error.h"
#include "expect_error.h"
#include "image/image.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

using ::testing::ElementsAre;

TEST(Video, EachStretchOfEqualMotionGivesItsSharpestFrame) {
  //                                 rest        |  quick
  const std::vector<double> motion = {0, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<double> sharpness = {1, 2, 9, 3, 4, 8, 5, 6};
  // Four units of motion in two stretches: up to the frame at 1 of 4, and from that at 2 of 4.
  EXPECT_THAT(ChooseFrames(sharpness, motion, 2), ElementsAre(2, 5));
  EXPECT_THAT(ChooseFrames(sharpness, motion, 4), ElementsAre(2, 4, 5, 7));
}

TEST(Video, APictureThatNeverChangesIsDividedEvenly) {
  const std::vector<double> rest(6, 0.0), sharpness = {1, 2, 1, 1, 3, 1};
  EXPECT_THAT(ChooseFrames(sharpness, rest, 2), ElementsAre(1, 4));
}

TEST(Video, BlurMakesAnImageLessSharp) {
  std::vector<uint8_t> stripes(30 * 20), blurred = stripes;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      stripes[size_t(y * 30 + x)] = x / 3 % 2 ? 200 : 50;
      blurred[size_t(y * 30 + x)] = x / 3 % 2 ? 150 : 100;
    }
  }
  // The variance scales with the square of the contrast.
  EXPECT_NEAR(SharpnessOf(stripes, 30, 20), 9 * SharpnessOf(blurred, 30, 20), 1e-6);
  EXPECT_EQ(SharpnessOf(std::vector<uint8_t>(600, 7), 30, 20), 0);
}

TEST(Video, FramesOfAVideoBecomePhotos) {
  const std::filesystem::path ffmpeg = FindProgram("ffmpeg");
  if (ffmpeg.empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  const ScratchFolder folder;
  // A name in which ffmpeg would find a pattern.
  const std::filesystem::path video = folder / "walk %03d.mp4";
  ASSERT_EQ(RunChild(ffmpeg,
                     {"-loglevel", "error", "-f", "lavfi", "-i",
                      "testsrc=size=160x120:rate=20:duration=2", "-pix_fmt", "yuv420p",
                      "file:" + (folder / "walk.mp4").string()},
                     {})
                .exit_code,
            0);
  std::filesystem::rename(folder / "walk.mp4", video);
  WriteVideoFrames(video, 5, folder / "frames", folder / "scratch");
  size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "frames")) {
    const Image frame = ReadImage(entry.path());
    EXPECT_EQ(frame.width, 160);
    EXPECT_EQ(frame.height, 120);
    ++count;
  }
  EXPECT_EQ(count, 5u);
  EXPECT_TRUE(std::filesystem::exists(folder / "frames/000001.jpg"));
}

TEST(Video, WhatIsNoVideoIsRefused) {
  if (FindProgram("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  const ScratchFolder folder;
  folder.Write("text.mp4", "not a video");
  // A playlist would make ffmpeg open whatever it names.
  folder.Write("list.mp4", "#EXTM3U\n#EXTINF:1,\n/etc/passwd\n#EXT-X-ENDLIST\n");
  for (const char* name : {"text.mp4", "list.mp4"}) {
    ExpectError<DataError>(
        [&] { WriteVideoFrames(folder / name, 5, folder / "frames", folder / "scratch"); },
        {name, "cannot be read as a video"});
  }
}

}  // namespace
}  // namespace tetrec
