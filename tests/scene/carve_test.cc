#include "scene/carve.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/rotation.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

SyntheticScene SomeScene(SyntheticKind kind) {
  SyntheticOptions options;
  options.kind = kind;
  options.train_views = 40;
  options.width = options.height = 100;
  options.rays_per_side = 2;
  return MakeSyntheticScene(options);
}

std::vector<AlphaMask> MasksOf(const SyntheticScene& synthetic) {
  std::vector<AlphaMask> masks;
  for (const int i : synthetic.scene.ViewsOf(Split::kTrain)) {
    masks.push_back({synthetic.scene.cameras[0], synthetic.scene.views[size_t(i)].cam_from_world,
                     AlphaOf(synthetic.images[size_t(i)])});
  }
  return masks;
}

const Bounds3 kWide{glm::dvec3(-1.5), glm::dvec3(1.5)};

TEST(CarveMasks, KeepsEveryCellThatTouchesTheSubject) {
  for (const SyntheticKind kind : {SyntheticKind::kBall, SyntheticKind::kTwoBalls}) {
    const OccupancyGrid grid = CarveMasks(MasksOf(SomeScene(kind)), kWide, {40, 32, 24});
    int touched = 0;
    for (int z = 0; z < 24; ++z) {
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 40; ++x) {
          bool touches = false;
          for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 offset(corner & 1, corner >> 1 & 1, corner >> 2);
            touches |=
                IsInSubject(kind, grid.CellCenter(x, y, z) + (offset - 0.5) * grid.CellSize());
          }
          if (!touches) continue;
          ++touched;
          EXPECT_TRUE(grid.Inside({x, y, z})) << x << " " << y << " " << z;
        }
      }
    }
    EXPECT_GT(touched, 500);
  }
}

TEST(CarveMasks, KeepsLittleMoreThanTheBall) {
  const Bounds3 box{glm::dvec3(-1.25), glm::dvec3(1.25)};
  const OccupancyGrid grid =
      CarveMasks(MasksOf(SomeScene(SyntheticKind::kBall)), box, {48, 48, 48}, 20);
  // A cell is kept when its square reaches the silhouette: at most its ball's half diagonal
  // (0.045), sqrt(2) of it at the square's corners, and a pixel (0.025 units) more. Between the
  // outlines of 40 views, 0.5 rad apart, the hull is larger by up to 1 / cos(0.25) - 1 = 3 %.
  const double reach = (0.9 + std::sqrt(2.0) * (0.045 + 0.025)) * 1.03;
  double farthest = 0;
  for (int z = 0; z < 48; ++z) {
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        if (grid.Inside({x, y, z})) {
          farthest = std::max(farthest, glm::length(grid.CellCenter(x, y, z)));
        }
      }
    }
  }
  EXPECT_LT(farthest, reach);
  EXPECT_GT(farthest, 0.9);
}

TEST(CarveMasks, KeepsAPartThinnerThanACellAndAPixel) {
  // A line of no width: in each mask only the pixels that its points fall into are opaque.
  const SyntheticScene synthetic = SomeScene(SyntheticKind::kBall);
  std::vector<AlphaMask> masks = MasksOf(synthetic);
  const glm::dvec3 from(-0.7, -0.31, 0.2), to(0.6, 0.4, -0.5);
  for (AlphaMask& mask : masks) {
    std::fill(mask.alpha.begin(), mask.alpha.end(), uint8_t{0});
    for (int i = 0; i <= 2000; ++i) {
      const glm::dvec3 point = from + (i / 2000.0) * (to - from);
      const glm::ivec2 pixel(mask.camera.ImageFromCam(mask.cam_from_world * point));
      mask.alpha[size_t(pixel.y) * 100 + size_t(pixel.x)] = 1;
    }
  }
  const OccupancyGrid grid = CarveMasks(masks, kWide, {48, 48, 48});
  for (int i = 0; i <= 2000; ++i) {
    const glm::dvec3 point = from + (i / 2000.0) * (to - from);
    EXPECT_TRUE(grid.Inside(grid.CellOf(point))) << i;
  }
  EXPECT_LT(grid.InsideCount(), 48u * 48 * 48 / 50);
}

TEST(CarveMasks, CountsCellsThatNoViewSeesAsOutside) {
  // One camera at the origin that looks along z, its mask opaque.
  const std::vector<AlphaMask> masks = {
      {Camera{10, 10, 10, 10, 5, 5}, Rigid3{}, std::vector<uint8_t>(100, 255)}};
  const OccupancyGrid grid = CarveMasks(masks, {{-1, -1, -8}, {1, 1, 8}}, {4, 4, 32});
  EXPECT_FALSE(grid.Inside(grid.CellOf({0.1, 0.1, -5})));
  EXPECT_TRUE(grid.Inside(grid.CellOf({0.1, 0.1, 5})));
  EXPECT_EQ(CarveMasks(masks, grid.bounds, grid.size, 2).InsideCount(), 0u);
  EXPECT_EQ(CarveMasks(masks, grid.bounds, grid.size, 0).InsideCount(), 4u * 4 * 32);
}

TEST(FindSubjectBounds, WrapsTheSubjectClosely) {
  const Bounds3 ball = FindSubjectBounds(MasksOf(SomeScene(SyntheticKind::kBall)));
  const Bounds3 pair = FindSubjectBounds(MasksOf(SomeScene(SyntheticKind::kTwoBalls)));
  EXPECT_TRUE(ball.Contains(glm::dvec3(0.9)) && ball.Contains(glm::dvec3(-0.9)));
  EXPECT_TRUE(pair.Contains({-0.95, -0.45, -0.5}) && pair.Contains({0.9, 0.6, 0.5}));
  // Two pixels (0.025 units each), a cell's ball (0.03) and the margin of 1 % on either side.
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(ball.Size()[axis], 1.8 + 2 * 0.12) << axis;
    EXPECT_LT(pair.Size()[axis], (glm::dvec3(1.85, 1.05, 1.0) + 2 * 0.12)[axis]) << axis;
  }
}

TEST(FindSubjectBounds, KeepsAPartThatMostImagesMiss) {
  const SyntheticOptions options = {.kind = SyntheticKind::kTwoBalls};
  const glm::dvec3 left_ball(-0.45, 0.1, 0);
  std::vector<AlphaMask> masks = MasksOf(SomeScene(options.kind));
  for (size_t i = 0; i < masks.size(); ++i) {
    if (i % 4 == 0) continue;  // sees both balls; the other views zoom in on the left one
    AlphaMask& mask = masks[i];
    mask.camera.fx = mask.camera.fy = 250;
    const glm::dvec3 origin = mask.cam_from_world.Inverse().translation;
    const glm::dvec3 forward = glm::normalize(left_ball - origin);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    mask.cam_from_world.rotation =
        glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
    mask.cam_from_world.translation = -(mask.cam_from_world.rotation * origin);
    const glm::dmat3 world_from_cam = glm::transpose(mask.cam_from_world.rotation);
    for (size_t p = 0; p < mask.alpha.size(); ++p) {
      const glm::dvec2 pixel(double(p % 100) + 0.5, double(p / 100) + 0.5);
      const RaySample sample =
          SampleSynthetic(options, origin, world_from_cam * mask.camera.CamFromImage(pixel));
      mask.alpha[p] = uint8_t(255 * sample.alpha);
    }
  }
  const Bounds3 pair = FindSubjectBounds(masks);
  EXPECT_TRUE(pair.Contains({-0.95, -0.45, -0.5}) && pair.Contains({0.9, 0.6, 0.5}));
}

TEST(FindSubjectBounds, MovesWithTheWorld) {
  // It works far from the origin and in small units, too, as in surveyed data.
  std::vector<AlphaMask> masks = MasksOf(SomeScene(SyntheticKind::kTwoBalls));
  const Bounds3 before = FindSubjectBounds(masks);
  const Similarity3 old_from_new{0.001, glm::dmat3(1.0), {-20, 10, 5}};
  for (AlphaMask& mask : masks)
    mask.cam_from_world = CamFromWorld(mask.cam_from_world, old_from_new);
  const Bounds3 after = FindSubjectBounds(masks);
  // Rounding may move a cell across the border of a pixel: one cell of 1 / 64.
  EXPECT_LT(glm::length(old_from_new * after.min - before.min), 0.05);
  EXPECT_LT(glm::length(old_from_new * after.max - before.max), 0.05);
}

TEST(FindSubjectBounds, SaysWhyThereAreNone) {
  std::vector<AlphaMask> masks = MasksOf(SomeScene(SyntheticKind::kBall));
  for (AlphaMask& mask : masks) std::fill(mask.alpha.begin(), mask.alpha.end(), uint8_t{0});
  ExpectError<DataError>([&] { FindSubjectBounds(masks); },
                         {"40 training views", "nothing in common"});
  for (AlphaMask& mask : masks) mask.cam_from_world.rotation = glm::dmat3(1.0);
  ExpectError<DataError>([&] { FindSubjectBounds(masks); },
                         {"along one line", "give the subject's bounds"});
}

TEST(BoxSeenByAll, IsWithinEveryImage) {
  const std::vector<AlphaMask> masks = MasksOf(SomeScene(SyntheticKind::kBall));
  const Bounds3 box = BoxSeenByAll(masks).value();
  EXPECT_GT(box.Size().x, 1.0);  // the views see a ball of radius 1.15: a cube of side 1.33
  for (const AlphaMask& mask : masks) {
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 pick(corner & 1, corner >> 1 & 1, corner >> 2);
      const glm::dvec3 in_cam = mask.cam_from_world * (box.min + pick * box.Size());
      const glm::dvec2 pixel = mask.camera.ImageFromCam(in_cam);
      EXPECT_TRUE(in_cam.z > 0 && pixel.x > 0 && pixel.y > 0 && pixel.x < 100 && pixel.y < 100);
    }
  }
}

TEST(BoxSeenByAll, DoesNotExistIfTheCamerasDoNotLookAtOnePlace) {
  std::vector<AlphaMask> outwards = MasksOf(SomeScene(SyntheticKind::kBall));
  std::vector<AlphaMask> parallel = outwards;
  for (AlphaMask& mask : outwards) {
    const Rigid3 place = mask.cam_from_world.Inverse();
    // Half a turn about the camera's own y axis.
    const Rigid3 turned{place.rotation * glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, -1),
                        place.translation};
    mask.cam_from_world = turned.Inverse();
  }
  for (AlphaMask& mask : parallel) mask.cam_from_world.rotation = glm::dmat3(1.0);
  EXPECT_FALSE(BoxSeenByAll(outwards));
  EXPECT_FALSE(BoxSeenByAll(parallel));
  ExpectError<DataError>(
      [&] { FindSubjectBounds(outwards); },
      {"away from each other", "give the subject's bounds", "triangulated points"});
}

TEST(BoxAroundCameras, GrowsTheirBoxByItsLongestSide) {
  std::vector<AlphaMask> masks;
  for (const glm::dvec3& place : {glm::dvec3(1, 2, 3), glm::dvec3(5, 2, 4)}) {
    masks.push_back({Camera{10, 10, 10, 10, 5, 5}, Rigid3{glm::dmat3(1.0), -place}, {}});
  }
  const Bounds3 box = BoxAroundCameras(masks);
  EXPECT_LT(glm::length(box.min - glm::dvec3(-3, -2, -1)), 1e-12);
  EXPECT_LT(glm::length(box.max - glm::dvec3(9, 6, 8)), 1e-12);
  masks[1] = masks[0];
  ExpectError<DataError>(
      [&] { BoxAroundCameras(masks); },
      {"cameras (2) are all at one place", "triangulation", "give the subject's bounds"});
}

TEST(ReadTrainingMasks, ReadsTheAlphaOfTrainingViewsOnly) {
  const ScratchFolder folder;
  SyntheticOptions options;
  options.train_views = 3;
  options.width = 20;
  options.height = 10;
  const SyntheticScene synthetic = MakeSyntheticScene(options);
  WriteSyntheticScene(folder.path(), synthetic);
  Scene scene = ReadScene(folder.path());
  const std::vector<AlphaMask> masks = ReadTrainingMasks(folder.path(), scene);
  ASSERT_EQ(masks.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(masks[i].alpha, AlphaOf(synthetic.images[i]));

  scene.cameras[0].width = 21;
  ExpectError<DataError>([&] { ReadTrainingMasks(folder.path(), scene); }, {"20 x 10", "21 x 10"});
  scene.has_alpha = false;
  ExpectError<DataError>([&] { ReadTrainingMasks(folder.path(), scene); }, {"no alpha"});
}

}  // namespace
}  // namespace tetrec
