// COLMAP models that are written and read.
#include "colmap/write_model.h"

#include "scratch_folder.h"

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(WriteColmapModel, WritesWhatIsRead) {
  ColmapModel model;
  model.cameras[3] = {LensModel::kOpenCv, 640, 480, {500, 501, 320, 240, 0.1, -0.02, 1e-3, 0}};
  model.cameras[4] = PinholeLens({64, 48, 50, 51, 32.5, 24});
  const glm::dmat3 turn = glm::mat3_cast(glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3))));
  model.images[7] = {"a b.jpg", 3, {turn, {1, -2, 3}}, {{{10.5, 20.25}, 9}, {{1, 2}}}};
  model.images[8] = {"sub/c.png", 4, {}, {}};
  model.points[9] = {{0.1, 0.2, -0.3}, {1, 128, 255}, 0.75, {{7, 0}}};
  model.points[10] = {{1e6, 0, 0}, {0, 0, 0}, 0, {}};
  const ScratchFolder folder;
  WriteColmapModel(folder / "sparse" / "0", model);

  const ColmapModel read = ReadColmapModel(folder / "sparse" / "0");
  ASSERT_EQ(read.cameras.size(), 2u);
  EXPECT_EQ(read.cameras.at(3).params, model.cameras[3].params);
  EXPECT_EQ(read.cameras.at(4).model, LensModel::kPinhole);
  EXPECT_EQ(read.cameras.at(4).params, (std::vector<double>{50, 51, 32.5, 24}));
  EXPECT_EQ(read.cameras.at(4).height, 48u);
  ASSERT_EQ(read.images.size(), 2u);
  const ColmapImage& image = read.images.at(7);
  EXPECT_EQ(image.name, "a b.jpg");
  EXPECT_EQ(image.camera, 3u);
  EXPECT_EQ(image.cam_from_world.translation, glm::dvec3(1, -2, 3));
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(glm::distance(image.cam_from_world.rotation[c], turn[c]), 1e-15);
  }
  ASSERT_EQ(image.observations.size(), 2u);
  EXPECT_EQ(image.observations[0].pixel, glm::dvec2(10.5, 20.25));
  EXPECT_EQ(image.observations[0].point, 9u);
  EXPECT_EQ(image.observations[1].point, kNoColmapPoint);
  ASSERT_EQ(read.points.size(), 2u);
  const ColmapPoint& point = read.points.at(9);
  EXPECT_EQ(point.position, glm::dvec3(0.1, 0.2, -0.3));
  EXPECT_EQ(point.color_srgb, (std::array<uint8_t, 3>{1, 128, 255}));
  EXPECT_EQ(point.error_px, 0.75);
  ASSERT_EQ(point.track.size(), 1u);
  EXPECT_EQ(point.track[0].image, 7u);
}

}  // namespace
}  // namespace tetrec
