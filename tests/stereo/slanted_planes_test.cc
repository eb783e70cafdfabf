#include "stereo/slanted_planes.h"

#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr int kPixels = 64;  // of a side
constexpr DepthRange kRange{0.8, 8};
// A wall through (0, 0, 2) that is turned by 50 degrees: from the left it is seen at a flat angle.
const glm::dvec3 kNormal(std::sin(0.87), 0, std::cos(0.87));

double WallTexture(double u, double v) {
  return 0.5 + 0.2 * std::sin(17 * u + 5 * v) + 0.2 * std::sin(7 * u - 19 * v + 1);
}

double DepthOfWall(const glm::dvec3& center, const glm::dvec3& ray) {
  return glm::dot(kNormal, glm::dvec3(0, 0, 2) - center) / glm::dot(kNormal, ray);
}

// A camera at (x, 0, 0) that looks along z.
StereoView ViewOfWall(double x) {
  StereoView view;
  view.camera = {kPixels, kPixels, 60, 60, kPixels / 2.0, kPixels / 2.0};
  view.cam_from_world.translation = {-x, 0, 0};
  for (int row = 0; row < kPixels; ++row) {
    for (int column = 0; column < kPixels; ++column) {
      const glm::dvec3 ray(view.camera.CamFromImage({column + 0.5, row + 0.5}));
      const glm::dvec3 center(x, 0, 0), hit = center + DepthOfWall(center, ray) * ray;
      const double along = glm::dot(hit, glm::dvec3(kNormal.z, 0, -kNormal.x));
      view.grey.push_back(float(WallTexture(along, hit.y)));
      view.kinds.push_back(PixelKind::kSeen);
    }
  }
  return view;
}

struct Wall {
  StereoView view = ViewOfWall(0), left = ViewOfWall(-0.5), right = ViewOfWall(0.5);
  std::vector<float> inverse_depths = std::vector<float>(size_t{kPixels} * kPixels, 0.5f);

  void Fit(const SlantedOptions& options = {}) {
    const std::vector<const StereoView*> neighbors = {&left, &right};
    FitSlantedPlanes(view, neighbors, kRange, options, inverse_depths);
  }
  // Of the pixels that both neighbours show, the share within 1 %.
  double RightShare() const {
    int right_ones = 0, pixels = 0;
    for (int y = 8; y < kPixels - 8; ++y) {
      for (int x = kPixels / 4; x < kPixels * 3 / 4; ++x) {
        const glm::dvec3 ray(view.camera.CamFromImage({x + 0.5, y + 0.5}));
        const double ratio =
            double(inverse_depths[view.Index(x, y)]) * DepthOfWall(glm::dvec3(0), ray);
        right_ones += std::abs(ratio - 1) < 0.01 ? 1 : 0;
        ++pixels;
      }
    }
    return double(right_ones) / pixels;
  }
};

TEST(FitSlantedPlanes, FindsATurnedWallFromDepthsThatAreAllTheSame) {
  Wall wall;
  EXPECT_LT(wall.RightShare(), 0.1);
  wall.Fit();
  EXPECT_GT(wall.RightShare(), 0.95);
}

TEST(FitSlantedPlanes, FindsItFromNoDepthsAndAgainInTheSameWay) {
  Wall first, second;
  for (Wall* wall : {&first, &second}) {
    wall->inverse_depths.assign(wall->inverse_depths.size(), 0.0f);
    wall->Fit();
  }
  EXPECT_GT(first.RightShare(), 0.9);
  EXPECT_EQ(first.inverse_depths, second.inverse_depths);
}

TEST(FitSlantedPlanes, DropsWhatDoesNotMatch) {
  SlantedOptions options;
  options.max_cost = 0.2;
  Wall wall, noisy;
  Random random(1, 2);
  for (StereoView* view : {&noisy.left, &noisy.right}) {
    for (float& grey : view->grey) grey = float(random.Uniform());
  }
  const auto kept_share = [&](Wall& of) {
    of.Fit(options);
    const auto kept = std::ranges::count_if(of.inverse_depths, [](float w) { return w > 0; });
    return double(kept) / double(of.inverse_depths.size());
  };
  EXPECT_GT(kept_share(wall), 0.8);
  // A search among many planes finds some by which even noise is alike.
  EXPECT_LT(kept_share(noisy), 0.2);
}

TEST(FitSlantedPlanes, LeavesPixelsOutThatShowNothing) {
  Wall wall;
  wall.view.kinds[wall.view.Index(20, 20)] = PixelKind::kEmpty;
  wall.view.kinds[wall.view.Index(21, 20)] = PixelKind::kOther;
  wall.Fit();
  EXPECT_EQ(wall.inverse_depths[wall.view.Index(20, 20)], 0.0f);
  EXPECT_EQ(wall.inverse_depths[wall.view.Index(21, 20)], 0.0f);
  EXPECT_GT(wall.inverse_depths[wall.view.Index(24, 20)], 0.0f);
}

}  // namespace
}  // namespace tetrec
