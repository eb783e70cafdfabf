// COLMAP's binary models: what is written is read, and nothing hostile is believed.
#include "colmap/model.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

namespace tetrec {
namespace {

using Bytes = std::vector<uint8_t>;

void WriteName(ByteWriter& writer, const std::string& name) {
  writer.WriteArray(std::span<const char>(name.c_str(), name.size() + 1));
}

// One SIMPLE_RADIAL camera.
Bytes Cameras(int32_t model = 2, double focal = 100, uint64_t width = 64) {
  ByteWriter w;
  w.Write(uint64_t{1});
  w.Write(uint32_t{7});
  w.Write(model);
  w.Write(width);
  w.Write(uint64_t{48});
  for (const double p : {focal, 32.0, 24.0, 0.01}) w.Write(p);
  return w.bytes();
}

struct ImageRecord {
  uint32_t id = 1;
  std::string name = "a.jpg";
  double qw = 1, tx = 0;
  uint32_t camera = 7;
  uint64_t point = 5;
};

Bytes Images(const std::vector<ImageRecord>& records) {
  ByteWriter w;
  w.Write(uint64_t{records.size()});
  for (const ImageRecord& r : records) {
    w.Write(r.id);
    for (const double v : {r.qw, 0.0, 0.0, 0.0, r.tx, 2.0, 3.0}) w.Write(v);
    w.Write(r.camera);
    WriteName(w, r.name);
    w.Write(uint64_t{2});
    for (const uint64_t point : {r.point, kNoColmapPoint}) {
      w.Write(10.5);
      w.Write(20.5);
      w.Write(point);
    }
  }
  return w.bytes();
}

Bytes Points(double x = 1, uint32_t image = 1, uint32_t observation = 0) {
  ByteWriter w;
  w.Write(uint64_t{1});
  w.Write(uint64_t{5});
  for (const double v : {x, 2.0, 3.0}) w.Write(v);
  w.Write(std::array<uint8_t, 3>{10, 20, 30});
  w.Write(0.5);
  w.Write(uint64_t{1});
  w.Write(image);
  w.Write(observation);
  return w.bytes();
}

ColmapModel Read(const Bytes& cameras, const Bytes& images, const Bytes& points,
                 DanglingReferences dangling = DanglingReferences::kRefuse) {
  const ScratchFolder folder;
  folder.Write("cameras.bin", cameras);
  folder.Write("images.bin", images);
  folder.Write("points3D.bin", points);
  return ReadColmapModel(folder.path(), dangling);
}

TEST(ColmapModel, EveryFieldIsReadFromItsPlace) {
  const ColmapModel model = Read(Cameras(), Images({{}}), Points());
  EXPECT_EQ(model.cameras.at(7).params, (std::vector<double>{100, 32, 24, 0.01}));
  EXPECT_EQ(model.cameras.at(7).height, 48u);
  const ColmapImage& image = model.images.at(1);
  EXPECT_EQ(image.name, "a.jpg");
  EXPECT_EQ(image.cam_from_world.translation, glm::dvec3(0, 2, 3));
  EXPECT_EQ(image.cam_from_world.rotation, glm::dmat3(1.0));
  EXPECT_EQ(image.observations[0].point, 5u);
  EXPECT_EQ(image.observations[1].point, kNoColmapPoint);
  const ColmapPoint& point = model.points.at(5);
  EXPECT_EQ(point.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(point.color_srgb[2], 30);
  EXPECT_EQ(MeanReprojectionError_px(model), 0.5);
  EXPECT_EQ(MeanTrackLength(model), 1.0);
}

TEST(ColmapModel, QuaternionsTurnAsColmapSays) {
  ByteWriter w;  // a quarter turn about z: x goes to y
  w.Write(uint64_t{1});
  w.Write(uint32_t{1});
  for (const double v : {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5), 0.0, 0.0, 0.0}) w.Write(v);
  w.Write(uint32_t{7});
  WriteName(w, "a");
  w.Write(uint64_t{0});
  const auto images = ParseColmapImages(w.bytes(), "images.bin");
  const glm::dvec3 turned = images.at(1).cam_from_world * glm::dvec3(1, 0, 0);
  EXPECT_NEAR(glm::distance(turned, glm::dvec3(0, 1, 0)), 0, 1e-15);  // rounding of sqrt(0.5)
}

TEST(ColmapModel, EveryTruncatedFileIsRefusedAndSoAreLeftovers) {
  const auto check = [](Bytes bytes, const std::function<void(std::span<const uint8_t>)>& parse) {
    EXPECT_NO_THROW(parse(bytes));
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THROW(parse(std::span(bytes).first(size)), DataError) << size << " bytes";
    }
    bytes.push_back(0);
    EXPECT_THROW(parse(bytes), DataError);
  };
  check(Cameras(), [](auto b) { ParseColmapCameras(b, "cameras.bin"); });
  check(Images({{}}), [](auto b) { ParseColmapImages(b, "images.bin"); });
  check(Points(), [](auto b) { ParseColmapPoints(b, "points3D.bin"); });
}

// COLMAP itself hangs or aborts on these.
TEST(ColmapModel, CountsBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  for (const uint64_t count : {uint64_t{2}, uint64_t{1} << 62, uint64_t{1} << 63, ~uint64_t{0}}) {
    const auto with = [&](Bytes bytes, size_t at) {
      std::memcpy(&bytes[at], &count, sizeof(count));
      return bytes;
    };
    ExpectError<DataError>([&] { ParseColmapCameras(with(Cameras(), 0), "c"); },
                           {"cameras do not fit"});
    ExpectError<DataError>([&] { ParseColmapImages(with(Images({{}}), 0), "i"); },
                           {"images do not fit"});
    ExpectError<DataError>([&] { ParseColmapPoints(with(Points(), 0), "p"); },
                           {"points do not fit"});
    // The counts inside the records: observations follow id, pose, camera and name.
    const size_t observations = 8 + 4 + 7 * 8 + 4 + 6, track = 8 + 8 + 24 + 3 + 8;
    if (count > 2) {
      ExpectError<DataError>([&] { ParseColmapImages(with(Images({{}}), observations), "i"); },
                             {"observations do not fit"});
    }
    ExpectError<DataError>([&] { ParseColmapPoints(with(Points(), track), "p"); },
                           {"track items do not fit"});
  }
}

TEST(ColmapModel, ValuesThatAreNotFiniteAreRefusedWithTheirByte) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    ExpectError<DataError>([&] { Read(Cameras(2, bad), Images({{}}), Points()); },
                           {"cameras.bin: byte", "a camera parameter is "});
    ExpectError<DataError>([&] { Read(Cameras(), Images({{.tx = bad}}), Points()); },
                           {"images.bin: byte", "a translation is "});
    ExpectError<DataError>([&] { Read(Cameras(), Images({{.qw = bad}}), Points()); },
                           {"images.bin: byte", "a rotation is "});
    ExpectError<DataError>([&] { Read(Cameras(), Images({{}}), Points(bad)); },
                           {"points3D.bin: byte", "a point is "});
  }
  ExpectError<DataError>([] { Read(Cameras(), Images({{.qw = 2}}), Points()); }, {"quaternion"});
  ExpectError<DataError>(
      [] { Read(Cameras(17), Images({{}}), Points()); },
      {"cameras.bin", "camera model 17 is unknown (expected 0 to 16: SIMPLE_PINHOLE",
       "image_undistorter"});
  ExpectError<DataError>([] { Read(Cameras(2, 100, 0), Images({{}}), Points()); }, {"0 x 48"});
  ExpectError<DataError>([] { Read(Cameras(2, 0), Images({{}}), Points()); },
                         {"cameras.bin: byte", "the focal length 0 px"});
}

TEST(ColmapModel, NamesThatLeaveTheFolderAreRefused) {
  for (const char* name : {"../a.jpg", "/a.jpg", "b/../../a.jpg", ""}) {
    ExpectError<DataError>([&] { Read(Cameras(), Images({{.name = name}}), Points()); },
                           {"relative path"});
  }
}

TEST(ColmapModel, NamesWithoutAnEndAreRefused) {
  ExpectError<DataError>(
      [] { Read(Cameras(), Images({{.name = std::string(5000, 'a')}}), Points()); },
      {"images.bin: byte", "an image's name does not end"});
}

TEST(ColmapModel, ReferencesToWhatDoesNotExistAreRefused) {
  ExpectError<DataError>([] { Read(Cameras(), Images({{.camera = 8}}), Points()); }, {"camera 8"});
  ExpectError<DataError>([] { Read(Cameras(), Images({{.point = 6}}), Points()); }, {"point 6"});
  ExpectError<DataError>([] { Read(Cameras(), Images({{}}), Points(1, 2)); }, {"image 2"});
  ExpectError<DataError>([] { Read(Cameras(), Images({{}}), Points(1, 1, 2)); }, {"observation 2"});
  ExpectError<DataError>([] { Read(Cameras(), Images({{}, {}}), Points()); }, {"twice"});
}

// Scripts that remove points or images from a model leave their observations and tracks.
TEST(ColmapModel, ReferencesToWhatDoesNotExistAreDroppedOnRequest) {
  const auto read = [](const Bytes& images, const Bytes& points) {
    return Read(Cameras(), images, points, DanglingReferences::kDrop);
  };
  TakeWarnings();
  EXPECT_EQ(read(Images({{}}), Points()).points.at(5).track.size(), 1u);
  EXPECT_TRUE(TakeWarnings().empty());
  EXPECT_EQ(read(Images({{.point = 6}}), Points()).images.at(1).observations[0].point,
            kNoColmapPoint);
  EXPECT_THAT(TakeWarnings(), testing::ElementsAre(testing::HasSubstr("removed: 1; left out")));
  EXPECT_TRUE(read(Images({{}}), Points(1, 2)).points.at(5).track.empty());
  EXPECT_TRUE(read(Images({{}}), Points(1, 1, 2)).points.at(5).track.empty());
  ExpectError<DataError>([&] { read(Images({{.camera = 8}}), Points()); }, {"camera 8"});
}

}  // namespace
}  // namespace tetrec
