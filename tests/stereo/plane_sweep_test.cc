#include "stereo/plane_sweep.h"

#include "stereo/semi_global.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

constexpr int kSize = 48;
constexpr double kFocal_px = 50, kPlaneDepth = 2, kBaseline = 0.4;

double TextureAt(double x, double y) {
  return 0.5 + 0.2 * std::sin(31 * x + 5 * y) + 0.2 * std::sin(9 * x - 27 * y + 1);
}

// A camera at (x, 0, 0) that looks along z at a textured plane z = kPlaneDepth; its grey values are
// changed by gain and offset.
StereoView ViewAt(double x, double gain = 1, double offset = 0) {
  StereoView view;
  view.camera = {kSize, kSize, kFocal_px, kFocal_px, kSize / 2.0, kSize / 2.0};
  view.cam_from_world.translation = {-x, 0, 0};
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const glm::dvec3 ray = view.camera.CamFromImage({column + 0.5, row + 0.5});
      const double grey = TextureAt(x + kPlaneDepth * ray.x, kPlaneDepth * ray.y);
      view.grey.push_back(float(offset + gain * grey));
      view.kinds.push_back(PixelKind::kSeen);
    }
  }
  return view;
}

struct Sweep {
  StereoView view = ViewAt(0), left, right;
  SweepPlanes planes;

  Sweep(double gain, double offset)
      : left(ViewAt(-kBaseline, gain, offset)), right(ViewAt(kBaseline, gain, offset)) {
    planes = ChoosePlanes(view, Neighbors(), {1, 4}, 1, 256);
  }
  std::vector<const StereoView*> Neighbors() const { return {&left, &right}; }
  CostVolume Costs() const { return SweepPlanesOf(view, Neighbors(), planes, 2); }
};

TEST(ChoosePlanes, MovesPixelsByOneFromPlaneToPlane) {
  const Sweep sweep(1, 0);
  EXPECT_NEAR(kFocal_px * kBaseline * sweep.planes.step, 1, 0.1);
  EXPECT_DOUBLE_EQ(sweep.planes.InverseDepth(0), 0.25);
  EXPECT_NEAR(sweep.planes.InverseDepth(sweep.planes.count - 1), 1, 1e-12);
}

TEST(SweepPlanesOf, CostsLeastAtTheTrueDepthWhateverTheExposure) {
  for (const double gain : {1.0, 0.4}) {
    const Sweep sweep(gain, 0.3 * (1 - gain));
    const PlaneChoice choice =
        ChooseSmoothPlanes(sweep.Costs(), sweep.view.grey, sweep.planes.count, {});
    for (int y = 4; y < kSize - 4; ++y) {
      for (int x = 4; x < kSize - 4; ++x) {
        const size_t i = sweep.view.Index(x, y);
        ASSERT_GE(choice.plane[i], 0) << x << " " << y;
        // A fifth of a plane is a fifth of a pixel.
        ASSERT_NEAR(sweep.planes.InverseDepth(choice.plane[i]), 1 / kPlaneDepth,
                    0.2 * sweep.planes.step)
            << x << " " << y << ", gain " << gain;
      }
    }
  }
}

TEST(SweepPlanesOf, TakesTheBetterOfTwoNeighboursWhereOneIsOccluded) {
  Sweep sweep(1, 0);
  for (float& grey : sweep.left.grey) grey = 0.5f;
  const CostVolume volume = sweep.Costs();
  const int plane = int(std::lround((1 / kPlaneDepth - sweep.planes.first) / sweep.planes.step));
  EXPECT_LT(volume.At(24, 24)[plane], 40);
}

TEST(SweepPlanesOf, KnowsNothingWhereNoNeighbourSeesThePixel) {
  Sweep sweep(1, 0);
  for (StereoView* view : {&sweep.left, &sweep.right}) {
    std::fill(view->kinds.begin(), view->kinds.end(), PixelKind::kOther);
  }
  EXPECT_EQ(sweep.Costs().At(24, 24)[3], kUnknownCost);
}

TEST(SweepPlanesOf, PutsNothingInFrontOfAnEmptyBackground) {
  Sweep sweep(1, 0);
  for (StereoView* view : {&sweep.left, &sweep.right}) {
    std::fill(view->kinds.begin(), view->kinds.end(), PixelKind::kEmpty);
  }
  EXPECT_EQ(sweep.Costs().At(24, 24)[3], kLargestCost);
}

TEST(ChooseSmoothPlanes, CarriesDepthAcrossAPlaceWithoutTexture) {
  CostVolume volume{20, 20, 16, {}};
  for (int i = 0; i < 20 * 20; ++i) {
    const bool is_flat = i % 20 > 7 && i % 20 < 12;
    for (int d = 0; d < 16; ++d) volume.costs.push_back(is_flat ? 200 : d == 5 ? 10 : 200);
  }
  const std::vector<float> grey(400, 0.5f);
  const PlaneChoice choice = ChooseSmoothPlanes(volume, grey, 16, {});
  for (const float plane : choice.plane) EXPECT_EQ(plane, 5);
}

TEST(ChooseSmoothPlanes, ChoosesNothingAtTheEndsOfTheRange) {
  CostVolume volume{4, 4, 16, {}};
  for (int i = 0; i < 16; ++i) {
    for (int d = 0; d < 16; ++d) volume.costs.push_back(d == 0 ? 0 : 200);
  }
  const PlaneChoice choice = ChooseSmoothPlanes(volume, std::vector<float>(16, 0.5f), 16, {});
  for (const float plane : choice.plane) EXPECT_LT(plane, 0);
}

}  // namespace
}  // namespace tetrec
