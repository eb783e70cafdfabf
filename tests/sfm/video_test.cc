#include "sfm/video.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/log.h"
#include "expect_error.h"
#include "image/image.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

// 20 frames, all blurred but every fourth.
std::filesystem::path WriteMostlyBlurred(const ScratchFolder& folder, const std::string& delay_s) {
  std::filesystem::path video = folder / "late.mkv";
  const std::vector<std::string> arguments = {
      "-loglevel",
      "error",
      "-y",
      "-f",
      "lavfi",
      "-i",
      "sine=duration=3",
      "-itsoffset",
      delay_s,
      "-f",
      "lavfi",
      "-i",
      "color=c=gray:size=480x270:rate=10:duration=2,drawgrid=w=6:h=6:color=white,"
      "boxblur=8:enable='mod(n,4)'",
      "-map",
      "1:v",
      "-map",
      "0:a",
      "-c:v",
      "libx264",
      "-qp",
      "4",
      "-pix_fmt",
      "yuv420p",
      "-c:a",
      "aac",
      "file:" + video.string()};
  EXPECT_EQ(RunChild(FindProgram("ffmpeg"), arguments, {}).exit_code, 0);
  return video;
}

double SharpnessOfPhoto(const std::filesystem::path& path) {
  const Image photo = ReadImage(path);
  std::vector<uint8_t> green;
  for (size_t i = 1; i < photo.pixels.size(); i += 3) green.push_back(photo.pixels[i]);
  return SharpnessOf(green, photo.width, photo.height);
}

TEST(Video, TheChosenFramesAreWrittenWhereTheSoundBeginsFirst) {
  if (FindProgram("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  for (const char* delay_s : {"0", "0.1", "0.35"}) {
    SCOPED_TRACE(delay_s);
    const ScratchFolder folder;
    WriteVideoFrames(WriteMostlyBlurred(folder, delay_s), 5, folder / "frames", folder / "scratch");
    for (int i = 1; i <= 5; ++i) {
      EXPECT_GT(SharpnessOfPhoto(folder / fmt::format("frames/00000{}.jpg", i)), 1000) << i;
    }
  }
}

// A still clip of three saturated stripes.
struct StripesClip {
  const char* size;
  const char* matrix;    // of its pixels
  const char* tag;       // of the file; empty: none
  const char* transfer;  // of the file
};

std::filesystem::path WriteStripes(const StripesClip& clip, const ScratchFolder& folder) {
  const auto stripe = [&](const char* color) {
    return fmt::format("color=c={}:size={}:rate=10:duration=1", color, clip.size);
  };
  const std::filesystem::path video = folder / "clip.mp4";
  std::vector<std::string> arguments = {"-loglevel", "error", "-y"};
  for (const char* color : {"0xC82828", "0x28B43C", "0x323CD2"}) {
    arguments.insert(arguments.end(), {"-f", "lavfi", "-i", stripe(color)});
  }
  arguments.insert(arguments.end(),
                   {"-filter_complex",
                    fmt::format("[0]format=gbrp[a];[1]format=gbrp[b];[2]format=gbrp[c];"
                                "[a][b][c]vstack=inputs=3,scale=out_color_matrix={}:out_range=tv,"
                                "format=yuv420p",
                                clip.matrix)});
  if (*clip.tag != 0) arguments.insert(arguments.end(), {"-colorspace", clip.tag});
  if (*clip.transfer != 0) arguments.insert(arguments.end(), {"-color_trc", clip.transfer});
  arguments.insert(arguments.end(), {"-c:v", "libx264", "-qp", "4", "file:" + video.string()});
  EXPECT_EQ(RunChild(FindProgram("ffmpeg"), arguments, {}).exit_code, 0);
  return video;
}

TEST(Video, FramesHaveTheColorsOfTheVideoWhateverItsMatrix) {
  if (FindProgram("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  const StripesClip clips[] = {{"640x120", "bt709", "bt709", ""},
                               {"640x120", "bt601", "smpte170m", ""},
                               // What specifies no matrix is taken as players take it.
                               {"640x120", "bt601", "", ""},
                               {"1280x240", "bt709", "", ""}};
  for (const StripesClip& clip : clips) {
    SCOPED_TRACE(fmt::format("{} {} '{}'", clip.size, clip.matrix, clip.tag));
    const ScratchFolder folder;
    WriteVideoFrames(WriteStripes(clip, folder), 3, folder / "frames", folder / "scratch");
    const Image frame = ReadImage(folder / "frames/000001.jpg");
    const int expected[3][3] = {{200, 40, 40}, {40, 180, 60}, {50, 60, 210}};
    for (int stripe = 0; stripe < 3; ++stripe) {
      const uint8_t* pixel = frame.At(frame.width / 2, (2 * stripe + 1) * frame.height / 6);
      // The other matrix is up to 30 levels off.
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], expected[stripe][c], 4) << stripe << c;
    }
  }
}

TEST(Video, AVideoThatGivesTwoPhotosIsRefused) {
  if (FindProgram("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  const ScratchFolder folder;
  const std::filesystem::path video = WriteStripes({"640x120", "bt709", "bt709", ""}, folder);
  ExpectError<DataError>([&] { WriteVideoFrames(video, 2, folder / "frames", folder / "scratch"); },
                         {"clip.mp4: gives only 2 photos, of 10 frames", "a longer video"});
}

TEST(Video, HdrIsNamed) {
  if (FindProgram("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not installed (scripts/setup.sh)";
  const ScratchFolder folder;
  const auto warnings = [&](const char* transfer) {
    TakeWarnings();
    WriteVideoFrames(WriteStripes({"640x120", "bt709", "bt709", transfer}, folder), 3,
                     folder / "frames", folder / "scratch");
    return TakeWarnings();
  };
  EXPECT_THAT(warnings("arib-std-b67"), ElementsAre(HasSubstr("clip.mp4: is an HDR video (HLG)")));
  EXPECT_THAT(warnings("bt709"), ElementsAre());
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
