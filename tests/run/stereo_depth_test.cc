#include "run/stereo_depth.h"

#include "core/error.h"
#include "core/file.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

StereoDepth SomeMap() {
  StereoDepth map = MakeStereoDepth(7, {3, 2, 30.5, 31, 1.5, 1});
  map.depth = {1, 0, 2.5f, 0, 1e-3f, 1e6f};
  map.agreement = {2, 0, 3, 0, 0, 255};
  return map;
}

std::vector<uint8_t> BytesOf(const StereoDepth& map) {
  const ScratchFolder folder;
  WriteStereoDepth(folder / "map", map);
  return ReadBytes(folder / "map");
}

TEST(StereoDepth, IsReadAsItWasWritten) {
  const StereoDepth map = SomeMap(), read = ParseStereoDepth(BytesOf(map), "map");
  EXPECT_EQ(read.view, 7u);
  EXPECT_EQ(read.camera.width, 3);
  EXPECT_EQ(read.camera.height, 2);
  EXPECT_EQ(read.camera.fx, 30.5);
  EXPECT_EQ(read.camera.fy, 31);
  EXPECT_EQ(read.camera.cx, 1.5);
  EXPECT_EQ(read.camera.cy, 1);
  EXPECT_EQ(read.depth, map.depth);
  EXPECT_EQ(read.agreement, map.agreement);
}

TEST(StereoDepth, CutOffAnywhereIsRefused) {
  const std::vector<uint8_t> bytes = BytesOf(SomeMap());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(ParseStereoDepth(std::span(bytes).first(size), "map"), DataError) << size;
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_THROW(ParseStereoDepth(longer, "map"), DataError);
}

TEST(StereoDepth, OfMorePixelsThanTheFileHasIsRefusedBeforeMemoryIsTaken) {
  std::vector<uint8_t> bytes = BytesOf(SomeMap());
  bytes[13] = bytes[17] = 0xF0;  // 61,443 x 61,442 pixels would take 19 GB
  EXPECT_THROW(ParseStereoDepth(bytes, "map"), DataError);
}

TEST(StereoDepth, WithValuesThatMeanNothingIsNotWritten) {
  const ScratchFolder folder;
  for (const float bad : {-1.0f, NAN, INFINITY}) {
    StereoDepth map = SomeMap();
    map.depth[2] = bad;
    EXPECT_THROW(WriteStereoDepth(folder / "map", map), DataError) << bad;
  }
  StereoDepth confirmed_nothing = SomeMap();
  confirmed_nothing.agreement[1] = 1;
  EXPECT_THROW(WriteStereoDepth(folder / "map", confirmed_nothing), DataError);
  StereoDepth no_focus = SomeMap();
  no_focus.camera.fx = 0;
  EXPECT_THROW(WriteStereoDepth(folder / "map", no_focus), DataError);
  EXPECT_FALSE(std::filesystem::exists(folder / "map"));
}

}  // namespace
}  // namespace tetrec
