// Lenses, their inverses, and the pinhole cameras that replace them.
#include "geometry/lens.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/undistorted_camera.h"
#include "lenses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tetrec {
namespace {

TEST(Lens, TheInverseOfEveryLensIsItsInverse) {
  for (const Lens& lens : LensesOfEveryModel()) {
    for (double y = 0; y <= 480; y += 40) {
      for (double x = 0; x <= 640; x += 40) {
        const glm::dvec2 back = DistortedImageFromCam(lens, CamFromDistortedImage(lens, {x, y}));
        // Newton's tolerance 1e-10 times the focal length.
        EXPECT_NEAR(glm::distance(back, glm::dvec2(x, y)), 0, 1e-7) << Name(lens.model);
      }
    }
    const glm::dvec2 center = DistortedImageFromCam(lens, {0, 0});
    EXPECT_LT(glm::length(CamFromDistortedImage(lens, center)), 1e-10) << Name(lens.model);
  }
}

void ExpectSameLens(const Lens& a, const Lens& b) {
  for (double y = -0.7; y < 0.8; y += 0.2) {
    for (double x = -0.9; x < 1; x += 0.2) {
      const glm::dvec2 at_a = DistortedImageFromCam(a, {x, y}),
                       at_b = DistortedImageFromCam(b, {x, y});
      EXPECT_NEAR(glm::distance(at_a, at_b), 0, 1e-9)
          << Name(a.model) << " " << Name(b.model) << " " << x << " " << y;
    }
  }
}

// No packaged COLMAP writes these models. Their special cases are models that it does write, and
// each other.
TEST(Lens, LaterLensesContainEarlierOnes) {
  ExpectSameLens(
      {LensModel::kRadTanThinPrismFisheye,
       640,
       480,
       {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01, 0, 0, 0, 0, 0, 0, 0, 0}},
      {LensModel::kOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01}});
  // Without radial terms it does not matter where the other terms are evaluated.
  ExpectSameLens({LensModel::kRadTanThinPrismFisheye,
                  640,
                  480,
                  {400, 410, 330, 235, 0, 0, 0, 0, 0, 0, 0.003, -0.002, 0.01, 0, -0.008, 0}},
                 {LensModel::kThinPrismFisheye,
                  640,
                  480,
                  {400, 410, 330, 235, 0, 0, -0.002, 0.003, 0, 0, 0.01, -0.008}});
  const Lens pinhole{LensModel::kPinhole, 640, 480, {400, 410, 330, 235}};
  const Lens fisheye{LensModel::kOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0, 0, 0, 0}};
  ExpectSameLens({LensModel::kFisheye, 640, 480, {400, 410, 330, 235}}, fisheye);
  ExpectSameLens({LensModel::kSimpleFisheye, 640, 480, {400, 330, 235}},
                 {LensModel::kFisheye, 640, 480, {400, 400, 330, 235}});
  ExpectSameLens({LensModel::kDivision, 640, 480, {400, 410, 330, 235, 0}}, pinhole);
  ExpectSameLens({LensModel::kEucm, 640, 480, {400, 410, 330, 235, 0, 1.7}}, pinhole);
  // Both are the stereographic projection here, 2 tan(angle / 2).
  ExpectSameLens({LensModel::kDivision, 640, 480, {400, 410, 330, 235, -0.25}},
                 {LensModel::kEucm, 640, 480, {400, 410, 330, 235, 0.5, 1}});
  ExpectSameLens({LensModel::kSimpleDivision, 640, 480, {400, 330, 235, -0.25}},
                 {LensModel::kDivision, 640, 480, {400, 400, 330, 235, -0.25}});
}

// The definitions that the authors of these lenses published, for one direction: the model that
// Project Aria calls FisheyeRadTanThinPrism, Fitzgibbon's division, from the image to the
// direction, and Khomutenko's unified camera.
TEST(Lens, LaterLensesFollowTheirAuthorsDefinitions) {
  const glm::dvec2 direction(0.3, -0.2);
  const double angle = std::atan(glm::length(direction));
  const Lens aria = RadTanLens();
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

  const Lens division{LensModel::kDivision, 640, 480, {500, 510, 330, 235, 0.15}};
  const glm::dvec2 place((600 - 330) / 500.0, (20 - 235) / 510.0);
  const glm::dvec2 expected = place / (1 + 0.15 * glm::dot(place, place));
  EXPECT_LT(glm::distance(CamFromDistortedImage(division, {600, 20}), expected), 1e-9);

  const Lens unified{LensModel::kEucm, 640, 480, {400, 410, 330, 235, 0.6, 1.2}};
  const double depth = 0.6 * std::sqrt(1.2 * glm::dot(direction, direction) + 1) + 0.4;
  const glm::dvec2 unified_pixel = DistortedImageFromCam(unified, direction);
  EXPECT_NEAR(unified_pixel.x, 400 * 0.3 / depth + 330, 1e-9);
  EXPECT_NEAR(unified_pixel.y, 410 * -0.2 / depth + 235, 1e-9);
}

TEST(Lens, WideLaterLensesAreCutAndThoseThatFoldOverRefused) {
  // Stereographic, 640 px for 116 degrees to each side.
  for (const Lens& wide : {Lens{LensModel::kSimpleDivision, 640, 480, {100, 320, 240, -0.25}},
                           Lens{LensModel::kEucm, 640, 480, {100, 100, 320, 240, 0.5, 1}}}) {
    EXPECT_TRUE(IsTooWideForPlane(wide)) << Name(wide.model);
    EXPECT_NEAR(UndistortedCamera(wide, 400).CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
    ExpectError<DataError>([&] { CamFromDistortedImage(wide, {0, 240}); }, {"90 degrees", "(0, 2"});
  }
  // b / (1 + k b^2) is largest at b = 1 / sqrt(k), here 150 pixels from the centre.
  const Lens folded{LensModel::kSimpleDivision, 640, 480, {300, 320, 240, 4}};
  ExpectError<DataError>([&] { UndistortedCamera(folded, 640); }, {"folds over", "pixel (0, 0)"});
  ExpectError<DataError>([&] { CamFromDistortedImage(folded, {0, 240}); }, {"folds over"});
}

// Parameters of any size give an error or a valid camera.
TEST(Lens, AbsurdLensesGiveACameraOrAnError) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-6, 12), side(-1, 1);
  size_t refused = 0, taken = 0;
  for (int i = 0; i < 15; ++i) {
    for (Lens lens : LensesOfEveryModel()) {
      lens.width = 64, lens.height = 48;
      for (double& value : lens.params) {
        if (side(random) > 0.5) value = std::copysign(std::pow(10, exponent(random)), side(random));
      }
      try {
        const Camera to = UndistortedCamera(lens, 16);
        EXPECT_LE(std::max(to.width, to.height), 16);
        EXPECT_GE(std::min(to.width, to.height), 1);
        EXPECT_TRUE(to.fx > 0 && to.fy > 0 && std::isfinite(to.fx + to.fy + to.cx + to.cy))
            << Name(lens.model);
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
TEST(Lens, ScaledLensesPutEveryDirectionAtTheSamePlaceInTheImage) {
  for (const Lens& lens : LensesOfEveryModel()) {
    const Lens scaled = ScaledLens(lens, 320, 160);
    for (const glm::dvec2& direction : {glm::dvec2(0.3, -0.2), glm::dvec2(-0.5, 0.4)}) {
      const glm::dvec2 before = DistortedImageFromCam(lens, direction);
      const glm::dvec2 after = DistortedImageFromCam(scaled, direction);
      EXPECT_NEAR(after.x, before.x / 2, 1e-9) << Name(lens.model);
      EXPECT_NEAR(after.y, before.y / 3, 1e-9) << Name(lens.model);
    }
  }
}

// The equidistant fisheye without further terms: pixel distance = focal length x angle.
TEST(Lens, FisheyesMeasureAngles) {
  const Lens lens{LensModel::kOpenCvFisheye, 640, 480, {300, 300, 320, 240, 0, 0, 0, 0}};
  for (const double degrees : {1.0, 30.0, 60.0, 85.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const glm::dvec2 pixel = DistortedImageFromCam(lens, {std::tan(angle), 0});
    EXPECT_NEAR(pixel.x - 320, 300 * angle, 1e-9);
  }
}

TEST(Lens, FisheyesOfAHalfSphereAreReportedAndCutAt60Degrees) {
  // 640 px for 183 degrees.
  const Lens lens{LensModel::kSimpleRadialFisheye, 640, 480, {200, 320, 240, 0}};
  EXPECT_TRUE(IsTooWideForPlane(lens));
  EXPECT_FALSE(IsTooWideForPlane(OpenCvLens()));
  const Camera to = UndistortedCamera(lens, 400);
  EXPECT_NEAR(to.CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
  ExpectError<DataError>([&] { CamFromDistortedImage(lens, {0, 240}); }, {"90 degrees", "(0, 2"});
}

// OpenCV's published formula, written out a second time for one direction.
TEST(Lens, TheOpenCvLensFollowsItsPublishedFormula) {
  const double x = 0.3, y = -0.2, r2 = 0.13, k1 = -0.12, k2 = 0.05, p1 = 0.002, p2 = -0.003;
  const double u = x * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double v = y * (1 + k1 * r2 + k2 * r2 * r2) + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  const glm::dvec2 pixel = DistortedImageFromCam(OpenCvLens(), {x, y});
  EXPECT_NEAR(pixel.x, 500 * u + 330, 1e-9);
  EXPECT_NEAR(pixel.y, 510 * v + 235, 1e-9);
}

TEST(Lens, EveryPixelOfThePinholeImageComesFromInsideThePhoto) {
  for (const int max_size : {100, 640, 5000}) {
    const Lens from = OpenCvLens();
    const Camera to = UndistortedCamera(from, max_size);
    EXPECT_LE(std::max(to.width, to.height), std::min(max_size, 640));
    EXPECT_NEAR(double(to.width) / to.height, 640.0 / 480.0, 1.0 / to.height);
    for (int y = 0; y <= to.height; y += std::max(1, to.height / 20)) {
      for (int x = 0; x <= to.width; x += std::max(1, to.width / 20)) {
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y));
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        // The window's borders are sampled at 257 points; between them the lens bends by less than
        // this.
        EXPECT_GE(std::min(pixel.x, pixel.y), -0.05);
        EXPECT_LE(pixel.x, 640.05);
        EXPECT_LE(pixel.y, 480.05);
      }
    }
  }
}

TEST(Lens, APinholeLensKeepsItsImageAndItsParameters) {
  const Camera to = UndistortedCamera(PinholeLens(), 640);
  EXPECT_EQ(to.width, 640);
  EXPECT_EQ(to.height, 480);
  EXPECT_NEAR(to.fx, 500, 1e-6);
  EXPECT_NEAR(to.cy, 235, 1e-6);
  const Camera half = UndistortedCamera(PinholeLens(), 320);
  EXPECT_NEAR(half.fx, 250, 1e-6);
  EXPECT_NEAR(half.cx, 165, 1e-6);
}

// Every direction of the pinhole image has exactly one pixel, and it is in the photo.
void ExpectUnfolded(const Lens& from, const Camera& to) {
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

TEST(Lens, FisheyesMayFoldOverBeyondWhatIsKept) {
  // Folds at 114 degrees, 1.574 focal lengths from the middle; the corners are at 1.71.
  const Lens wide{
      LensModel::kOpenCvFisheye, 820, 820, {340, 340, 410, 410, -0.03, 0.003, -0.003, 0.0002}};
  const Camera to = UndistortedCamera(wide, 820);
  EXPECT_TRUE(IsTooWideForPlane(wide));
  EXPECT_NEAR(to.CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
  ExpectUnfolded(wide, to);
  ExpectError<DataError>([&] { CamFromDistortedImage(wide, {0, 60}); }, {"(0, 60)", "folds over"});

  // theta (1 - k theta^2) folds at theta = 1 / sqrt(3 k): at 64 degrees, beyond 60 to the side but
  // before the corners of that view, at 68. The corners then end at 60.
  const double fold = 64 * std::numbers::pi / 180;
  const Lens narrow{
      LensModel::kSimpleRadialFisheye, 640, 480, {300, 320, 240, -1 / (3 * fold * fold)}};
  const Camera cut = UndistortedCamera(narrow, 640);
  EXPECT_TRUE(IsTooWideForPlane(narrow));
  EXPECT_LE(glm::length(glm::dvec2(cut.CamFromImage({0, 0}))), std::sqrt(3.0) + 1e-9);
  ExpectUnfolded(narrow, cut);
}

TEST(Lens, FisheyesThatFoldOverWithinWhatIsKeptAreRefused) {
  const double fold = 40 * std::numbers::pi / 180;
  const Lens lens{
      LensModel::kSimpleRadialFisheye, 640, 480, {300, 320, 240, -1 / (3 * fold * fold)}};
  ExpectError<DataError>([&] { UndistortedCamera(lens, 640); },
                         {"cannot be undone at pixel", "folds over"});
  // Folded twice nearly everywhere: rotated by half a turn, not mirrored.
  ExpectError<DataError>(
      [] {
        UndistortedCamera({LensModel::kSimpleRadialFisheye, 640, 480, {300, 320.5, 240.5, -3000}},
                          640);
      },
      {"cannot be undone at pixel", "folds over"});
}

TEST(Lens, LensesThatFoldOverOrAreUnknownAreRefused) {
  ExpectError<DataError>(
      [] {
        UndistortedCamera({LensModel::kSimpleRadial, 640, 480, {300, 320, 240, -3.0}}, 640);
      },
      {"cannot be undone at pixel", "folds over"});
  ExpectError<DataError>(
      [] {
        UndistortedCamera({LensModel::kPinhole, 640, 480, {-500, 510, 330, 235}}, 640);
      },
      {"focal lengths -500"});
  ExpectError<DataError>(
      [] {
        UndistortedCamera({LensModel(17), 640, 480, {500, 320, 240, 0}}, 640);
      },
      {"camera model 17", "0 to 16"});
}

}  // namespace
}  // namespace tetrec
