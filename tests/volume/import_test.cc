// Import of volumes as scene folders: cameras, frames, ground truth, options.
#include "volume/import.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cstring>

namespace tetrec {
namespace {

constexpr const char* kFunction =
    R"({"opacity": [[0, 0], [1, 1]], "colour": [[0, 1, 0, 0], [1, 0, 0, 1]]})";

VolumeImportOptions Small() {
  VolumeImportOptions options;
  options.dimensions = glm::ivec3(3, 2, 5);
  options.sample_type = SampleType::kUint8;
  options.spacing = glm::dvec3(1, 4, 0.5);
  options.cameras = 24;
  options.size_px = 16;
  return options;
}

// 3 x 2 x 5 samples: 0, 8, 16, ...
std::string SmallSamples() {
  std::string bytes;
  for (int i = 0; i < 30; ++i) bytes += char(8 * i);
  return bytes;
}

class VolumeImport : public ::testing::Test {
 protected:
  ImportedVolume Import(const std::string& to, const VolumeImportOptions& options) {
    ImportedVolume imported = ReadVolumeForImport(folder_.Write("v.raw", SmallSamples()),
                                                  folder_.Write("tf.json", kFunction), options);
    WriteImportedVolume(imported, options.rays_per_side, folder_ / to);
    return imported;
  }
  ScratchFolder folder_;
};

TEST_F(VolumeImport, WritesAWholeScene) {
  Import("scene", Small());
  const Scene scene = ReadScene(folder_ / "scene");
  EXPECT_TRUE(scene.has_alpha);
  EXPECT_EQ(scene.ViewsOf(Split::kTest).size(), 3u);
  EXPECT_EQ(scene.ViewsOf(Split::kValidation).size(), 3u);
  EXPECT_EQ(scene.ViewsOf(Split::kTrain).size(), 18u);
  // 2 x 4 x 2 in the file's units: the second side is the longest.
  EXPECT_EQ(scene.input_from_world.scale, 2);
  EXPECT_EQ(scene.input_from_world.translation, glm::dvec3(1, 2, 1));
  EXPECT_EQ(scene.subject_bounds.min, glm::dvec3(-0.5, -1, -0.5));
  EXPECT_EQ(scene.subject_bounds.max, glm::dvec3(0.5, 1, 0.5));
  bool any = false;
  for (const View& view : scene.views) {
    const Image image = ReadImage(folder_ / "scene" / view.image);
    EXPECT_EQ(image.width, 16);
    EXPECT_EQ(image.channels, 4);
    EXPECT_EQ(int(image.At(0, 0)[3]), 0);
    any = any || image.At(8, 8)[3] > 100;
  }
  EXPECT_TRUE(any);
}

TEST_F(VolumeImport, EveryCameraSeesTheWholeVolume) {
  const Scene scene = Import("scene", Small()).scene;
  const Bounds3& box = scene.subject_bounds;
  for (const View& view : scene.views) {
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 point(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                             corner & 4 ? box.max.z : box.min.z);
      const glm::dvec3 in_cam = view.cam_from_world * point;
      EXPECT_GT(in_cam.z, 0);
      const glm::dvec2 pixel = scene.cameras[0].ImageFromCam(in_cam);
      EXPECT_TRUE(pixel.x >= 0 && pixel.y >= 0 && pixel.x <= 16 && pixel.y <= 16);
    }
    const glm::dvec3 center = view.cam_from_world * glm::dvec3(0.0);
    EXPECT_NEAR(glm::length(glm::dvec2(center)), 0, 1e-12);
    EXPECT_NEAR(center.z, 2.5 * 0.5 * box.Diagonal(), 1e-12);
  }
}

TEST_F(VolumeImport, CamerasAreSpreadOverTheSphereAndTurnedByTheSeed) {
  VolumeImportOptions options = Small();
  options.cameras = 1000;
  Scene a, b, c;
  AddSphereOfViews(options, 1, a);
  AddSphereOfViews(options, 1, b);
  options.seed = 1;
  AddSphereOfViews(options, 1, c);
  glm::dvec3 mean(0.0);
  for (size_t i = 0; i < a.views.size(); ++i) {
    const glm::dvec3 position = a.views[i].cam_from_world.Inverse().translation;
    mean += position / 1000.0;
    double nearest = 9;
    for (size_t j = 0; j < a.views.size(); ++j) {
      if (j == i) continue;
      nearest = std::min(nearest,
                         glm::length(position - a.views[j].cam_from_world.Inverse().translation));
    }
    // Each camera has 4 pi 2.5^2 / 1000 of the sphere, a square of side 0.28.
    EXPECT_GT(nearest, 0.15);
    EXPECT_LT(nearest, 0.35);
    EXPECT_EQ(a.views[i].cam_from_world.translation, b.views[i].cam_from_world.translation);
    EXPECT_NE(a.views[i].cam_from_world.rotation, c.views[i].cam_from_world.rotation);
  }
  EXPECT_LT(glm::length(mean), 0.01);
}

TEST_F(VolumeImport, GroundTruthContainsDensityAndColourOfEverySample) {
  VolumeImportOptions options = Small();
  options.attenuation = 10;
  Import("scene", options);
  const std::vector<uint8_t> bytes = ReadBytes(folder_ / "scene/ground_truth/volume.nrrd");
  const std::string text(bytes.begin(), bytes.end());
  const size_t begin = text.find("\n\n") + 2;
  const std::string header = text.substr(0, begin);
  for (const char* part : {"sizes: 4 3 2 5\n", "type: float\n",
                           "space directions: none (0.5,0,0) (0,2,0) (0,0,0.25)\n",
                           "space origin: (-0.5,-1,-0.5)\n"}) {
    EXPECT_THAT(header, ::testing::HasSubstr(part));
  }
  ASSERT_EQ(bytes.size() - begin, 30 * 4 * sizeof(float));
  const TransferFunction function = ReadTransferFunction(folder_ / "tf.json", {0, 1});
  for (int i = 0; i < 30; ++i) {
    glm::vec4 value;
    std::memcpy(&value, bytes.data() + begin + size_t(i) * sizeof(value), sizeof(value));
    // The longest side is 2 world units, so 10 along it is 5 per unit.
    EXPECT_NEAR(value.x, 5 * 8 * i / 255.0, 1e-6);
    const glm::dvec3 color = function.SrgbAt(8 * i / 255.0);
    EXPECT_NEAR(value.y, color.r, 5e-4);
    EXPECT_NEAR(value.w, color.b, 5e-4);
  }
}

TEST_F(VolumeImport, TheGroundTruthIsWrittenBeforeTheImages) {
  // A folder in place of the file has the effect of a full disk.
  std::filesystem::create_directories(folder_ / "scene/ground_truth/volume.nrrd");
  ExpectError<EnvironmentError>([&] { Import("scene", Small()); },
                                {"ground_truth/volume.nrrd: cannot write", "bytes"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene/ground_truth/volume.nrrd.tmp"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene/images"));
}

TEST_F(VolumeImport, AVolumeTooLargeForMemoryIsRefusedBeforeAnythingIsRead) {
  VolumeLayout layout;
  layout.size = {1024, 1024, 512};
  constexpr uint64_t kNeeded = uint64_t{10} << 30;  // 20 bytes per sample
  EXPECT_NO_THROW(CheckVolumeMemory(layout, "v.raw", {kNeeded, "the host"}));
  ExpectError<EnvironmentError>(
      [&] {
        CheckVolumeMemory(layout, "v.raw", {kNeeded - (uint64_t{1} << 30), "the host"});
      },
      {"v.raw", "1024 x 1024 x 512 samples", "10.0 GiB", "the host has 9.0 GiB", "second sample"});

  const auto function = folder_.Write("tf.json", kFunction);
  const FreeMemory little = {599, "the host"};
  ExpectError<EnvironmentError>(
      [&] { ReadVolumeForImport(folder_.Write("v.raw", "short"), function, Small(), little); },
      {"3 x 2 x 5 samples"});
  ExpectError<EnvironmentError>(
      [&] {
        ReadVolumeForImport(
            folder_.Write("v.nhdr",
                          "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 5\nencoding: "
                          "raw\ndata file: none.raw\n"),
            function, VolumeImportOptions(), little);
      },
      {"v.nhdr", "3 x 2 x 5 samples"});
}

// Values of 12 bits in 16: 0, 140, ... 4060.
std::string TwelveBits() {
  std::string bytes;
  for (int i = 0; i < 30; ++i) {
    bytes += char(140 * i % 256);
    bytes += char(140 * i / 256);
  }
  return bytes;
}

class TwelveBitImport : public VolumeImport {
 protected:
  TwelveBitImport() { options_.sample_type = SampleType::kUint16; }
  ImportedVolume ImportWith(const char* function) {
    return ReadVolumeForImport(folder_.Write("v.raw", TwelveBits()),
                               folder_.Write("tf.json", function), options_);
  }
  VolumeImportOptions options_ = Small();
};

TEST_F(TwelveBitImport, AVolumeThatNoImageWouldShowIsRefused) {
  constexpr const char* kFromThird = R"({"opacity": [[0.2, 0], [0.6, 1], [0.6001, 0], [0.8, 0],
      [1, 1]], "colour": [[0, 1, 0, 0]]})";
  ExpectError<DataError>([&] { ImportWith(kFromThird); },
                         {"v.raw: nothing in it is visible", "samples range from 0 to 4060",
                          "tf.json", "above 0 at the values 13107 to 39327.6, 52428 to 65535",
                          "a value range LOW,HIGH", "the values 0 and 65535"});
  ExpectError<DataError>(
      [&] { ImportWith(R"({"opacity": [[0, 0]], "colour": [[0, 1, 0, 0]]})"); },
      {"nothing in it is visible", "tf.json has opacity 0 everywhere", "raise it"});
  // With the data's own range it is visible.
  options_.value_range = glm::dvec2(0, 4060);
  const ImportedVolume imported = ImportWith(kFromThird);
  EXPECT_EQ(imported.rays.CountDense(), 18u);  // at i / 29: 6 to 17 and 24 to 29
  EXPECT_EQ(imported.file->volume.clamped, 0u);
}

TEST_F(TwelveBitImport, WarnsIfTheDataUseASmallPartOfTheTypesRange) {
  const auto warnings = [&](const char* function) {
    TakeWarnings();
    ImportWith(function);
    std::string all;
    for (const std::string& warning : TakeWarnings()) all += warning;
    return all;
  };
  const std::string warning = warnings(kFunction);
  for (const char* part :
       {"v.raw", "0 to 4060", "uint16's 0 to 65535", "refer to the type's range", "value range"}) {
    EXPECT_THAT(warning, ::testing::HasSubstr(part));
  }
  // Positions that are values do not depend on the type.
  EXPECT_EQ(warnings(R"([{"ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 4000, 0, 0, 1],
                          "Points": [0, 0, 0.5, 0, 4000, 1, 0.5, 0]}])"),
            "");
  options_.value_range = glm::dvec2(0, 4095);
  EXPECT_EQ(warnings(kFunction), "");
  options_ = Small();
  TakeWarnings();
  Import("scene", options_);
  EXPECT_EQ(TakeWarnings().size(), 0u);
}

TEST_F(VolumeImport, HoldoutOfZeroTrainsOnAll) {
  VolumeImportOptions options = Small();
  options.holdout = 0;
  Scene scene;
  AddSphereOfViews(options, 1, scene);
  EXPECT_EQ(scene.ViewsOf(Split::kTrain).size(), 24u);
}

TEST_F(VolumeImport, WrongOptionsAreNamed) {
  const auto refused = [](const auto& change, std::initializer_list<std::string> parts) {
    VolumeImportOptions options = Small();
    change(options);
    ExpectError<UsageError>(
        [&] {
          options.Check();
          options.CheckFor("v.raw");
        },
        parts);
  };
  using Options = VolumeImportOptions;
  refused([](Options& o) { o.dimensions.reset(); }, {"v.raw", "give its dimensions"});
  refused([](Options& o) { o.dimensions->z = 1; }, {"1 samples along z"});
  refused([](Options& o) { o.dimensions->z = -5; }, {"-5 samples along z"});
  refused([](Options& o) { o.sample_type.reset(); }, {"v.raw", "sample type"});
  refused([](Options& o) { o.spacing->y = 0; }, {"spacing", "a spacing of 0"});
  refused([](Options& o) { o.spacing->y = NAN; }, {"a spacing of nan"});
  const auto range = [](double low, double high) {
    return [=](Options& o) { o.value_range = glm::dvec2(low, high); };
  };
  refused(range(5, 5), {"value-range is 5,5", "two numbers", "below the second"});
  refused(range(0, NAN), {"value-range is 0,nan"});
  refused(range(-1e308, 1e308), {"value-range"});
  refused([](Options& o) { o.attenuation = 0; }, {"attenuation is 0"});
  refused([](Options& o) { o.cameras = 2; }, {"cameras is 2"});
  refused([](Options& o) { o.size_px = 0; }, {"size is 0"});
  refused([](Options& o) { o.holdout = 2; }, {"holdout is 2"});
  refused([](Options& o) { o.rays_per_side = 0; }, {"rays-per-side is 0"});
  refused([](Options& o) { o.background = Background::kScene; }, {"background is scene"});
  ExpectError<UsageError>([] { Small().CheckFor("v.nrrd"); }, {"dimensions", "v.nrrd"});
}

TEST(VolumeImportOptions, AreReadFromText) {
  EXPECT_EQ(ParseDimensions("3x2x-5"), glm::ivec3(3, 2, -5));
  EXPECT_EQ(ParseSpacing("1x4x0.5"), glm::dvec3(1, 4, 0.5));
  for (const char* text : {"3x2", "3x2x5x1", "3,2,5", ""}) {
    ExpectError<UsageError>([&] { ParseDimensions(text); },
                            {std::string("dimensions is ") + text, "like 103x94x161"});
  }
  ExpectError<UsageError>([] { ParseSpacing("1x1"); }, {"spacing is 1x1"});
}

}  // namespace
}  // namespace tetrec
