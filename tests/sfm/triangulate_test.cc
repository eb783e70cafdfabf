// Triangulation with known cameras by the installed COLMAP: points of a scene with a known surface.
#include "sfm/triangulate.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "image/image.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tetrec {
namespace {

constexpr double kRadius = 0.9;  // of the synthetic ball

// A random grey level for each small cube of space: far rougher than the synthetic texture.
double Speckle(const glm::dvec3& point) {
  const glm::dvec3 cell = glm::floor(point / 0.06);
  const double noise = std::sin(glm::dot(cell, glm::dvec3(12.9898, 78.233, 37.719))) * 43758.5453;
  return 40 + 200 * (noise - std::floor(noise));
}

// Paints the pixels that show the ball, by the mean of 4 x 4 rays per pixel.
void PaintSpeckles(const Camera& camera, const Rigid3& cam_from_world, Image& image) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const glm::dvec3& from = world_from_cam.translation;
  for (int i = 0; i < image.width * image.height; ++i) {
    const glm::dvec2 pixel(i % image.width, i / image.width);
    double sum = 0;
    int hits = 0;
    for (int ray = 0; ray < 16; ++ray) {
      const glm::dvec2 offset{(ray % 4 + 0.5) / 4, (ray / 4 + 0.5) / 4};
      const glm::dvec3 along =
          glm::normalize(world_from_cam.rotation * camera.CamFromImage(pixel + offset));
      const double half = glm::dot(from, along);
      const double squared = half * half - glm::dot(from, from) + kRadius * kRadius;
      if (squared < 0) continue;
      sum += Speckle(from + (-half - std::sqrt(squared)) * along);
      ++hits;
    }
    if (hits > 0) std::fill_n(&image.pixels[size_t(i) * 4], 3, uint8_t(sum / hits));
  }
}

// A speckled ball of radius 0.9; every third image is smaller and belongs to a second camera.
class TriangulateTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (FindProgram("colmap").empty()) GTEST_SKIP() << "there is no colmap in PATH";
    SyntheticOptions options;
    options.train_views = 18;
    options.validation_views = 0;
    options.test_views = 1;
    options.width = options.height = 200;
    options.rays_per_side = 2;
    SyntheticScene synthetic = MakeSyntheticScene(options);
    scene_ = synthetic.scene;
    scene_.background = Background::kWhite;
    const Camera whole = scene_.cameras.at(0);
    const double scale = 150.0 / 200;
    scene_.cameras.push_back(
        {150, 150, whole.fx * scale, whole.fy * scale, whole.cx * scale, whole.cy * scale});
    for (size_t i = 0; i < scene_.views.size(); ++i) {
      PaintSpeckles(whole, scene_.views[i].cam_from_world, synthetic.images[i]);
      if (i % 3 == 0) {
        scene_.views[i].camera = 1;
        synthetic.images[i] = ResizeByArea(synthetic.images[i], 150, 150);
      }
      alphas_.push_back(AlphaOf(synthetic.images[i]));
    }
    WriteSyntheticScene(folder_ / "scene", {scene_, synthetic.images});
  }

  Triangulation Run(const std::string& work) const {
    std::filesystem::create_directories(folder_ / work);
    return TriangulatePoints(folder_ / "scene", scene_, alphas_,
                             {folder_ / "log.txt", folder_ / (work + "/cache"), folder_ / work});
  }

  ScratchFolder folder_;
  Scene scene_;
  ViewAlphas alphas_;
};

TEST_F(TriangulateTest, PointsAreOnTheBallReproducibleAndNotWhereAViewSeesThrough) {
  const Triangulation found = Run("a");
  EXPECT_EQ(found.points.size() + found.weak + found.transparent, found.found);
  ASSERT_GT(found.points.size(), 50u);
  std::vector<double> off;
  for (const ScenePoint& point : found.points) {
    off.push_back(std::abs(glm::length(point.position) - kRadius));
    EXPECT_GE(point.track_length, 3u);
    EXPECT_LE(point.reprojection_error_px, 2.0f);
  }
  std::sort(off.begin(), off.end());
  // A pixel covers about 0.013 units there; features are located to a fraction of a pixel.
  EXPECT_LT(off[off.size() / 2], 0.005);
  EXPECT_LT(off[off.size() * 95 / 100], 0.03);

  const Triangulation again = Run("b");
  ASSERT_EQ(again.points.size(), found.points.size());
  for (size_t i = 0; i < found.points.size(); ++i) {
    EXPECT_EQ(again.points[i].position, found.points[i].position);
    EXPECT_EQ(again.points[i].track_length, found.points[i].track_length);
  }

  // Now one training view sees nothing of the subject, so it sees through all points in front of
  // it.
  const int view = scene_.ViewsOf(Split::kTrain)[0];
  std::fill(alphas_[size_t(view)].begin(), alphas_[size_t(view)].end(), uint8_t{0});
  ExpectError<DataError>([&] { Run("b"); }, {"triangulation found no point", "18 images"});
}

// COLMAP itself aborts on these.
TEST_F(TriangulateTest, ImagesWithoutFeaturesGiveAnError) {
  for (const View& view : scene_.views) {
    const Camera& camera = scene_.cameras[size_t(view.camera)];
    WriteImage(folder_ / ("scene/" + view.image), MakeImage(camera.width, camera.height, 4));
  }
  ExpectError<DataError>([&] { Run("a"); }, {"triangulation found no point", "18 images"});
}

TEST(Triangulate, WithoutColmapThereIsAnError) {
  const std::string before = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  ExpectError<EnvironmentError>([] { TriangulatePoints(".", {}, {}, {}); }, {"no colmap in PATH"});
  setenv("PATH", before.c_str(), 1);
}

}  // namespace
}  // namespace tetrec
