// Undistortion: the lens and its inverse, the pinhole camera, and the resampled picture.
#include "scene/colmap_undistort.h"

#include "core/child_process.h"
#include "core/error.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tetrec {
namespace {

// One camera of every model of COLMAP 3.8, distorted by several per cent of the width.
std::vector<ColmapCamera> CamerasOfColmap38() {
  return {{kColmapSimplePinhole, 640, 480, {500, 330, 235}},
          {kColmapPinhole, 640, 480, {500, 510, 330, 235}},
          {kColmapSimpleRadial, 640, 480, {500, 330, 235, 0.1}},
          {kColmapRadial, 640, 480, {500, 330, 235, -0.15, 0.05}},
          {kColmapOpenCv, 640, 480, {500, 510, 330, 235, -0.12, 0.05, 0.004, -0.003}},
          {kColmapOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01}},
          {kColmapFullOpenCv,
           640,
           480,
           {500, 510, 330, 235, 0.2, 0.1, 0.003, -0.002, 0.03, 0.3, 0.05, 0.02}},
          {kColmapFov, 640, 480, {420, 430, 330, 235, 0.9}},
          {kColmapSimpleRadialFisheye, 640, 480, {400, 330, 235, 0.06}},
          {kColmapRadialFisheye, 640, 480, {400, 330, 235, 0.06, -0.04}},
          {kColmapThinPrismFisheye,
           640,
           480,
           {400, 410, 330, 235, 0.05, -0.03, 0.003, -0.002, 0.02, -0.01, 0.01, -0.008}}};
}

ColmapCamera RadTanCamera() {
  return {kColmapRadTanThinPrismFisheye,
          640,
          480,
          {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01, 0.006, -0.002, 0.003, -0.002, 0.01, -0.004,
           -0.008, 0.003}};
}

// Those of later versions too.
std::vector<ColmapCamera> CamerasOfEveryModel() {
  std::vector<ColmapCamera> cameras = CamerasOfColmap38();
  cameras.push_back(RadTanCamera());
  cameras.push_back({kColmapSimpleDivision, 640, 480, {500, 330, 235, -0.2}});
  cameras.push_back({kColmapDivision, 640, 480, {500, 510, 330, 235, 0.15}});
  cameras.push_back({kColmapSimpleFisheye, 640, 480, {400, 330, 235}});
  cameras.push_back({kColmapFisheye, 640, 480, {400, 410, 330, 235}});
  cameras.push_back({kColmapEucm, 640, 480, {400, 410, 330, 235, 0.6, 1.2}});
  return cameras;
}

// A strong barrel lens with all terms; 1 % of the width at the corners and more.
ColmapCamera OpenCvCamera() {
  return {kColmapOpenCv, 640, 480, {500, 510, 330, 235, -0.12, 0.05, 0.002, -0.003}};
}
ColmapCamera PinholeCamera() { return {kColmapPinhole, 640, 480, {500, 510, 330, 235}}; }

TEST(Undistort, TheInverseOfEveryLensIsItsInverse) {
  for (const ColmapCamera& camera : CamerasOfEveryModel()) {
    for (double y = 0; y <= 480; y += 40) {
      for (double x = 0; x <= 640; x += 40) {
        const glm::dvec2 back =
            DistortedImageFromCam(camera, CamFromDistortedImage(camera, {x, y}));
        // Newton's tolerance 1e-10 times the focal length.
        EXPECT_NEAR(glm::distance(back, glm::dvec2(x, y)), 0, 1e-7) << camera.model;
      }
    }
    const glm::dvec2 center = DistortedImageFromCam(camera, {0, 0});
    EXPECT_LT(glm::length(CamFromDistortedImage(camera, center)), 1e-10) << camera.model;
  }
}

void ExpectSameLens(const ColmapCamera& a, const ColmapCamera& b) {
  for (double y = -0.7; y < 0.8; y += 0.2) {
    for (double x = -0.9; x < 1; x += 0.2) {
      const glm::dvec2 at_a = DistortedImageFromCam(a, {x, y}),
                       at_b = DistortedImageFromCam(b, {x, y});
      EXPECT_NEAR(glm::distance(at_a, at_b), 0, 1e-9)
          << a.model << " " << b.model << " " << x << " " << y;
    }
  }
}

// No COLMAP that packages bring writes these models; they have others as special cases, which it
// does write, and each other.
TEST(Undistort, LaterLensesContainEarlierOnes) {
  ExpectSameLens({kColmapRadTanThinPrismFisheye,
                  640,
                  480,
                  {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01, 0, 0, 0, 0, 0, 0, 0, 0}},
                 {kColmapOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01}});
  // Without radial terms it does not matter by which place the others go.
  ExpectSameLens({kColmapRadTanThinPrismFisheye,
                  640,
                  480,
                  {400, 410, 330, 235, 0, 0, 0, 0, 0, 0, 0.003, -0.002, 0.01, 0, -0.008, 0}},
                 {kColmapThinPrismFisheye,
                  640,
                  480,
                  {400, 410, 330, 235, 0, 0, -0.002, 0.003, 0, 0, 0.01, -0.008}});
  const ColmapCamera pinhole{kColmapPinhole, 640, 480, {400, 410, 330, 235}};
  const ColmapCamera fisheye{kColmapOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0, 0, 0, 0}};
  ExpectSameLens({kColmapFisheye, 640, 480, {400, 410, 330, 235}}, fisheye);
  ExpectSameLens({kColmapSimpleFisheye, 640, 480, {400, 330, 235}},
                 {kColmapFisheye, 640, 480, {400, 400, 330, 235}});
  ExpectSameLens({kColmapDivision, 640, 480, {400, 410, 330, 235, 0}}, pinhole);
  ExpectSameLens({kColmapEucm, 640, 480, {400, 410, 330, 235, 0, 1.7}}, pinhole);
  // Both are the stereographic projection there, 2 tan(angle / 2).
  ExpectSameLens({kColmapDivision, 640, 480, {400, 410, 330, 235, -0.25}},
                 {kColmapEucm, 640, 480, {400, 410, 330, 235, 0.5, 1}});
  ExpectSameLens({kColmapSimpleDivision, 640, 480, {400, 330, 235, -0.25}},
                 {kColmapDivision, 640, 480, {400, 400, 330, 235, -0.25}});
}

// The definitions that the authors of these lenses published, for one direction: of the model that
// Project Aria calls FisheyeRadTanThinPrism, of Fitzgibbon's division, from the picture to the
// direction, and of Khomutenko's unified camera.
TEST(Undistort, LaterLensesAreThoseOfTheirAuthors) {
  const glm::dvec2 direction(0.3, -0.2);
  const double angle = std::atan(glm::length(direction));
  const ColmapCamera aria = RadTanCamera();
  const auto& p = aria.params;
  double factor = 1;
  for (int i = 0; i < 6; ++i) factor += p[4 + size_t(i)] * std::pow(angle, 2 * i + 2);
  const glm::dvec2 u = direction / glm::length(direction) * angle * factor;
  const double rr = glm::dot(u, u), dot = 2 * (u.x * p[10] + u.y * p[11]);
  const double x = u.x + dot * u.x + p[10] * rr + p[12] * rr + p[13] * rr * rr;
  const double y = u.y + dot * u.y + p[11] * rr + p[14] * rr + p[15] * rr * rr;
  const glm::dvec2 pixel = DistortedImageFromCam(aria, direction);
  EXPECT_NEAR(pixel.x, 400 * x + 330, 1e-9);
  EXPECT_NEAR(pixel.y, 410 * y + 235, 1e-9);

  const ColmapCamera division{kColmapDivision, 640, 480, {500, 510, 330, 235, 0.15}};
  const glm::dvec2 place((600 - 330) / 500.0, (20 - 235) / 510.0);
  const glm::dvec2 expected = place / (1 + 0.15 * glm::dot(place, place));
  EXPECT_LT(glm::distance(CamFromDistortedImage(division, {600, 20}), expected), 1e-9);

  const ColmapCamera unified{kColmapEucm, 640, 480, {400, 410, 330, 235, 0.6, 1.2}};
  const double depth = 0.6 * std::sqrt(1.2 * glm::dot(direction, direction) + 1) + 0.4;
  const glm::dvec2 unified_pixel = DistortedImageFromCam(unified, direction);
  EXPECT_NEAR(unified_pixel.x, 400 * 0.3 / depth + 330, 1e-9);
  EXPECT_NEAR(unified_pixel.y, 410 * -0.2 / depth + 235, 1e-9);
}

TEST(Undistort, WideLaterLensesAreCutAndThoseThatFoldOverRefused) {
  // Stereographic, 640 px for 116 degrees to each side.
  for (const ColmapCamera& wide :
       {ColmapCamera{kColmapSimpleDivision, 640, 480, {100, 320, 240, -0.25}},
        ColmapCamera{kColmapEucm, 640, 480, {100, 100, 320, 240, 0.5, 1}}}) {
    EXPECT_TRUE(IsTooWideForPlane(wide)) << wide.model;
    EXPECT_NEAR(UndistortedCamera(wide, 400).CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
    ExpectError<DataError>([&] { CamFromDistortedImage(wide, {0, 240}); }, {"90 degrees", "(0, 2"});
  }
  // b / (1 + k b^2) is largest at b = 1 / sqrt(k), here 150 pixels from the centre.
  const ColmapCamera folded{kColmapSimpleDivision, 640, 480, {300, 320, 240, 4}};
  ExpectError<DataError>([&] { UndistortedCamera(folded, 640); }, {"folds over", "pixel (0, 0)"});
  ExpectError<DataError>([&] { CamFromDistortedImage(folded, {0, 240}); }, {"folds over"});
}

// Parameters of any size: an error, or a camera that can be one.
TEST(Undistort, AbsurdLensesGiveACameraOrAnError) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-6, 12), side(-1, 1);
  size_t refused = 0, taken = 0;
  for (int i = 0; i < 15; ++i) {
    for (ColmapCamera camera : CamerasOfEveryModel()) {
      camera.width = 64, camera.height = 48;
      for (double& value : camera.params) {
        if (side(random) > 0.5) value = std::copysign(std::pow(10, exponent(random)), side(random));
      }
      try {
        const Camera to = UndistortedCamera(camera, 16);
        EXPECT_LE(std::max(to.width, to.height), 16);
        EXPECT_GE(std::min(to.width, to.height), 1);
        EXPECT_TRUE(to.fx > 0 && to.fy > 0 && std::isfinite(to.fx + to.fy + to.cx + to.cy))
            << camera.model;
        ++taken;
      } catch (const DataError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(taken, 20);
  EXPECT_GT(refused, 20);
}

// A copy of half the width and a third of the height.
TEST(Undistort, ScaledLensesPutEveryDirectionAtTheSamePlaceOfThePicture) {
  for (const ColmapCamera& camera : CamerasOfEveryModel()) {
    const ColmapCamera scaled = ScaledLens(camera, 320, 160);
    for (const glm::dvec2& direction : {glm::dvec2(0.3, -0.2), glm::dvec2(-0.5, 0.4)}) {
      const glm::dvec2 before = DistortedImageFromCam(camera, direction);
      const glm::dvec2 after = DistortedImageFromCam(scaled, direction);
      EXPECT_NEAR(after.x, before.x / 2, 1e-9) << camera.model;
      EXPECT_NEAR(after.y, before.y / 3, 1e-9) << camera.model;
    }
  }
}

// The equidistant fisheye without further terms: pixel distance = focal length x angle.
TEST(Undistort, FisheyesMeasureAngles) {
  const ColmapCamera camera{kColmapOpenCvFisheye, 640, 480, {300, 300, 320, 240, 0, 0, 0, 0}};
  for (const double degrees : {1.0, 30.0, 60.0, 85.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const glm::dvec2 pixel = DistortedImageFromCam(camera, {std::tan(angle), 0});
    EXPECT_NEAR(pixel.x - 320, 300 * angle, 1e-9);
  }
}

TEST(Undistort, FisheyesOfAHalfSphereAreCutAt60DegreesAndItIsTold) {
  // 640 px for 183 degrees.
  const ColmapCamera camera{kColmapSimpleRadialFisheye, 640, 480, {200, 320, 240, 0}};
  EXPECT_TRUE(IsTooWideForPlane(camera));
  EXPECT_FALSE(IsTooWideForPlane(OpenCvCamera()));
  const Camera to = UndistortedCamera(camera, 400);
  EXPECT_NEAR(to.CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
  ExpectError<DataError>([&] { CamFromDistortedImage(camera, {0, 240}); }, {"90 degrees", "(0, 2"});
}

TEST(Undistort, AlphaIsPremultipliedWhileFiltering) {
  // Green, opaque on the left; on the right invisible red, which must not bleed in.
  Image photo = MakeImage(640, 480, 4);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const bool left = x < 321;
      const uint8_t rgba[4] = {uint8_t(left ? 0 : 255), uint8_t(left ? 200 : 0), 0,
                               uint8_t(left ? 255 : 0)};
      std::copy_n(rgba, 4, photo.At(x, y));
    }
  }
  const Camera to = UndistortedCamera(OpenCvCamera(), 200);
  const Image picture = Undistort(photo, OpenCvCamera(), to);
  int mixed = 0;
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const uint8_t* pixel = picture.At(x, y);
      EXPECT_EQ(pixel[0], 0);
      EXPECT_EQ(pixel[1], pixel[3] > 0 ? 200 : 0);
      mixed += pixel[3] > 0 && pixel[3] < 255;
    }
  }
  EXPECT_GT(mixed, to.height / 2);  // the border between them
}

// OpenCV's published formula, written out a second time for one direction.
TEST(Undistort, TheLensIsThatOfTheBooks) {
  const double x = 0.3, y = -0.2, r2 = 0.13, k1 = -0.12, k2 = 0.05, p1 = 0.002, p2 = -0.003;
  const double u = x * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double v = y * (1 + k1 * r2 + k2 * r2 * r2) + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  const glm::dvec2 pixel = DistortedImageFromCam(OpenCvCamera(), {x, y});
  EXPECT_NEAR(pixel.x, 500 * u + 330, 1e-9);
  EXPECT_NEAR(pixel.y, 510 * v + 235, 1e-9);
}

TEST(Undistort, EveryPixelOfThePinholePictureComesFromInsideThePhoto) {
  for (const int max_size : {100, 640, 5000}) {
    const ColmapCamera from = OpenCvCamera();
    const Camera to = UndistortedCamera(from, max_size);
    EXPECT_LE(std::max(to.width, to.height), std::min(max_size, 640));
    EXPECT_NEAR(double(to.width) / to.height, 640.0 / 480.0, 1.0 / to.height);
    for (int y = 0; y <= to.height; y += std::max(1, to.height / 20)) {
      for (int x = 0; x <= to.width; x += std::max(1, to.width / 20)) {
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y));
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        // The window's borders are sampled at 257 points; between them the lens bends by less.
        EXPECT_GE(std::min(pixel.x, pixel.y), -0.05);
        EXPECT_LE(pixel.x, 640.05);
        EXPECT_LE(pixel.y, 480.05);
      }
    }
  }
}

TEST(Undistort, APinholeCameraKeepsItsPictureAndItsParameters) {
  const Camera to = UndistortedCamera(PinholeCamera(), 640);
  EXPECT_EQ(to.width, 640);
  EXPECT_EQ(to.height, 480);
  EXPECT_NEAR(to.fx, 500, 1e-6);
  EXPECT_NEAR(to.cy, 235, 1e-6);
  const Camera half = UndistortedCamera(PinholeCamera(), 320);
  EXPECT_NEAR(half.fx, 250, 1e-6);
  EXPECT_NEAR(half.cx, 165, 1e-6);
}

// A linear ramp of brightness goes through bilinear samples and area means unchanged: its value at
// a target pixel's centre is the ramp at the place that the lens gives, but for the curvature of
// the lens inside a pixel and rounding to 8 bits.
TEST(Undistort, PixelsLandWhereTheLensSays) {
  const ColmapCamera from = OpenCvCamera();
  Image photo{640, 480, 3, std::vector<uint8_t>(640 * 480 * 3)};
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      photo.At(x, y)[0] = uint8_t(std::lround((x + 0.5) * 255 / 640));
      photo.At(x, y)[1] = uint8_t(std::lround((y + 0.5) * 255 / 480));
      photo.At(x, y)[2] = 77;
    }
  }
  for (const int max_size : {200, 640}) {
    const Camera to = UndistortedCamera(from, max_size);
    const Image picture = Undistort(photo, from, to);
    ASSERT_EQ(picture.width, to.width);
    for (int y = 2; y < to.height - 2; y += 7) {
      for (int x = 2; x < to.width - 2; x += 7) {
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y) + 0.5);
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        EXPECT_NEAR(picture.At(x, y)[0], pixel.x * 255 / 640, 1.1);  // two roundings of 0.5 each
        EXPECT_NEAR(picture.At(x, y)[1], pixel.y * 255 / 480, 1.1);
        EXPECT_EQ(picture.At(x, y)[2], 77);
      }
    }
  }
}

constexpr const char* kModelNames[] = {"SIMPLE_PINHOLE",
                                       "PINHOLE",
                                       "SIMPLE_RADIAL",
                                       "RADIAL",
                                       "OPENCV",
                                       "OPENCV_FISHEYE",
                                       "FULL_OPENCV",
                                       "FOV",
                                       "SIMPLE_RADIAL_FISHEYE",
                                       "RADIAL_FISHEYE",
                                       "THIN_PRISM_FISHEYE"};

// Waves along x in red, along y in green, along both in blue; their slopes tell places.
constexpr double kWave_px = 40, kSwing = 100;
double Wave(double x) { return 128 + kSwing * std::sin(2 * std::numbers::pi * x / kWave_px); }
double WaveSlope(double x) {
  const double turns = 2 * std::numbers::pi / kWave_px;
  return kSwing * turns * std::cos(turns * x);
}

Image WavesPicture() {
  Image photo = MakeImage(640, 480, 3);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const double levels[3] = {Wave(x + 0.5), Wave(y + 0.5), Wave(0.7 * (x + y))};
      for (int k = 0; k < 3; ++k) photo.At(x, y)[k] = uint8_t(std::lround(levels[k]));
    }
  }
  return photo;
}

// Least squares for the shift [px] along one axis of waves of a block of pixels.
struct ShiftSum {
  double slope_difference = 0, slope_slope = 0;
  double Shift_px() const { return slope_slope > 0 ? slope_difference / slope_slope : 0; }
};

// The largest shift between where the lens puts blocks of 32 x 32 pixels and where they are in
// `picture`, which another program undistorted.
double LargestShift_px(const ColmapCamera& from, const Camera& to, const Image& picture) {
  double largest = 0;
  for (int top = 0; top + 32 <= to.height; top += 32) {
    for (int left = 0; left + 32 <= to.width; left += 32) {
      ShiftSum sums[2];
      for (int i = 0; i < 32 * 32; ++i) {
        const int x = left + i % 32, y = top + i / 32;
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y) + 0.5);
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        for (int axis = 0; axis < 2; ++axis) {
          const double slope = WaveSlope(pixel[axis]);
          sums[axis].slope_difference += slope * (picture.At(x, y)[axis] - Wave(pixel[axis]));
          sums[axis].slope_slope += slope * slope;
        }
      }
      largest = std::max({largest, std::abs(sums[0].Shift_px()), std::abs(sums[1].Shift_px())});
    }
  }
  return largest;
}

double MeanDifference(const Image& a, const Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / double(a.pixels.size());
}

TEST(Undistort, EveryModelOfItsVersionIsUndistortedAsColmapDoesIt) {
  const std::filesystem::path colmap = FindProgram("colmap");
  if (colmap.empty()) GTEST_SKIP() << "there is no colmap in PATH";
  const ScratchFolder folder;
  const std::vector<ColmapCamera> cameras = CamerasOfColmap38();
  const Image photo = WavesPicture();
  std::string camera_lines, image_lines;
  for (size_t i = 0; i < cameras.size(); ++i) {
    camera_lines +=
        fmt::format("{} {} 640 480 {}\n", i + 1, kModelNames[i], fmt::join(cameras[i].params, " "));
    image_lines += fmt::format("{} 1 0 0 0 0 0 0 {} {}.png\n\n", i + 1, i + 1, i);
    std::filesystem::create_directories(folder / "photos");
    WriteImage(folder / fmt::format("photos/{}.png", i), photo);
  }
  folder.Write("model/cameras.txt", camera_lines);
  folder.Write("model/images.txt", image_lines);
  folder.Write("model/points3D.txt", "");
  ChildOptions options;
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  options.log = folder / "log.txt";
  RunChild(colmap,
           {"image_undistorter", "--image_path", folder / "photos", "--input_path",
            folder / "model", "--output_path", folder / "flat"},
           options);
  const ColmapModel flat = ReadColmapModel(folder / "flat/sparse");
  ASSERT_EQ(flat.images.size(), cameras.size());
  for (const auto& [id, image] : flat.images) {
    const ColmapCamera& target = flat.cameras.at(image.camera);
    std::vector<double> p = target.params;
    if (target.model == kColmapSimplePinhole) p.insert(p.begin(), p[0]);
    ASSERT_LE(target.model, kColmapPinhole);
    const Camera to{int(target.width), int(target.height), p[0], p[1], p[2], p[3]};
    const Image theirs = ReadImage(folder / ("flat/images/" + image.name));
    const ColmapCamera& from = cameras[size_t(id - 1)];
    const double shift_px = LargestShift_px(from, to, theirs);
    const double difference = MeanDifference(Undistort(photo, from, to), theirs);
    std::printf("%-22s %d x %d: %.4f px, %.3f grey levels\n", kModelNames[from.model], to.width,
                to.height, shift_px, difference);
    // What the project promises; rounding to 8 bits alone gives 0.002 px and 0.3 levels.
    EXPECT_LT(shift_px, 0.05) << kModelNames[from.model];
    EXPECT_LT(difference, 1.0) << kModelNames[from.model];
  }
}

// Every direction of the pinhole picture has its pixel in the photo, and so far only one.
void ExpectUnfolded(const ColmapCamera& from, const Camera& to) {
  for (int y = 0; y <= to.height; y += 10) {
    for (int x = 0; x <= to.width; x += 10) {
      const glm::dvec3 direction = to.CamFromImage({x, y});
      const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
      EXPECT_TRUE(pixel.x > -0.5 && pixel.x < double(from.width) + 0.5 && pixel.y > -0.5 &&
                  pixel.y < double(from.height) + 0.5)
          << x << " " << y;
      const glm::dvec2 back = CamFromDistortedImage(from, pixel);
      EXPECT_LT(glm::distance(back, glm::dvec2(direction)), 1e-6) << x << " " << y;
    }
  }
}

TEST(Undistort, FisheyesMayFoldOverBeyondWhatIsKept) {
  // Folds at 114 degrees, 1.574 focal lengths from the middle; the corners are at 1.71.
  const ColmapCamera wide{
      kColmapOpenCvFisheye, 820, 820, {340, 340, 410, 410, -0.03, 0.003, -0.003, 0.0002}};
  const Camera to = UndistortedCamera(wide, 820);
  EXPECT_TRUE(IsTooWideForPlane(wide));
  EXPECT_NEAR(to.CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
  ExpectUnfolded(wide, to);
  ExpectError<DataError>([&] { CamFromDistortedImage(wide, {0, 60}); }, {"(0, 60)", "folds over"});

  // theta (1 - k theta^2) folds at theta = 1 / sqrt(3 k): at 64 degrees, beyond 60 to the side but
  // before the corners of those, at 68. These end at 60 then.
  const double fold = 64 * std::numbers::pi / 180;
  const ColmapCamera narrow{
      kColmapSimpleRadialFisheye, 640, 480, {300, 320, 240, -1 / (3 * fold * fold)}};
  const Camera cut = UndistortedCamera(narrow, 640);
  EXPECT_TRUE(IsTooWideForPlane(narrow));
  EXPECT_LE(glm::length(glm::dvec2(cut.CamFromImage({0, 0}))), std::sqrt(3.0) + 1e-9);
  ExpectUnfolded(narrow, cut);
}

TEST(Undistort, FisheyesThatFoldOverWithinWhatIsKeptAreRefused) {
  const double fold = 40 * std::numbers::pi / 180;
  const ColmapCamera camera{
      kColmapSimpleRadialFisheye, 640, 480, {300, 320, 240, -1 / (3 * fold * fold)}};
  ExpectError<DataError>([&] { UndistortedCamera(camera, 640); },
                         {"cannot be undone at pixel", "folds over"});
  // Folded twice nearly everywhere: turned by half a turn, not mirrored.
  ExpectError<DataError>(
      [] {
        UndistortedCamera({kColmapSimpleRadialFisheye, 640, 480, {300, 320.5, 240.5, -3000}}, 640);
      },
      {"cannot be undone at pixel", "folds over"});
}

TEST(Undistort, ComplaintsNamePictureLensAndAdvice) {
  const ColmapCamera camera{kColmapSimpleRadial, 640, 480, {300, 320, 240, -3.0}};
  ExpectError<DataError>(
      [&] {
        NamingLens(
            "photos/a.jpg", camera, [&] { UndistortedCamera(camera, 640); }, "try another");
      },
      {"photos/a.jpg (lens SIMPLE_RADIAL): the lens distortion", "folds over; try another"});
}

TEST(Undistort, LensesThatFoldOverOrAreUnknownAreRefused) {
  ExpectError<DataError>(
      [] {
        UndistortedCamera({2, 640, 480, {300, 320, 240, -3.0}}, 640);
      },
      {"cannot be undone at pixel", "folds over"});
  ExpectError<DataError>(
      [] {
        UndistortedCamera({1, 640, 480, {-500, 510, 330, 235}}, 640);
      },
      {"focal lengths -500"});
  ExpectError<DataError>(
      [] {
        UndistortedCamera({17, 640, 480, {500, 320, 240, 0}}, 640);
      },
      {"camera model 17", "0 to 16"});
}

}  // namespace
}  // namespace tetrec
