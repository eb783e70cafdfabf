#include "surface/texture_photos.h"

#include "core/error.h"
#include "expect_error.h"
#include "run/camera_corrections.h"
#include "run/left_out_photos.h"
#include "run/photo_exposures.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(TexturePhotos, TrainingPhotosComeWithTheirCorrectionsAndOutlinesAreNotTrusted) {
  const ScratchFolder scene_folder, field_folder;
  SyntheticOptions options;
  options.train_views = 3;
  options.validation_views = options.test_views = 1;
  const SyntheticScene synthetic = MakeSyntheticScene(options);
  WriteSyntheticScene(scene_folder / "", synthetic);
  const View& first = synthetic.scene.views[size_t(synthetic.scene.ViewsOf(Split::kTrain)[0])];
  WritePhotoExposures(field_folder / kPhotoExposuresFile,
                      {{first.name, glm::dvec3(1.25), glm::dvec3(-0.1)}});
  Rigid3 corrected = first.cam_from_world;
  corrected.translation.x += 0.01;
  WriteCameraCorrections(field_folder / kCameraCorrectionsFile,
                         {{first.name, corrected, 0, 0.01, 1}});

  const TriangleMesh ball = Sphere(0.6, glm::dvec3(0.0));
  auto photos = ReadTexturePhotos(scene_folder / "", field_folder / "");
  FindTrust(ball, photos);
  ASSERT_EQ(photos.size(), 3);
  EXPECT_EQ(photos[0].gain, glm::dvec3(1.25));
  EXPECT_EQ(photos[0].offset, glm::dvec3(-0.1));
  EXPECT_NEAR(photos[0].cam_from_world.translation.x, corrected.translation.x, 1e-12);
  EXPECT_EQ(photos[1].gain, glm::dvec3(1.0));
  for (const TexturePhoto& photo : photos) {
    // The middle shows the ball, which ends inside the photo.
    EXPECT_EQ(photo.trust[photo.Index(32, 32)], kFullTrust);
    int outline = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x + 1 < 64; ++x) {
        const size_t i = photo.Index(x, y);
        if (std::isfinite(photo.depth[i]) == std::isfinite(photo.depth[i + 1])) continue;
        ++outline;
        EXPECT_EQ(photo.trust[i], 0);
        EXPECT_EQ(photo.trust[i + 1], 0);
      }
    }
    EXPECT_GT(outline, 10);
    EXPECT_EQ(photo.trust[photo.Index(0, 30)], 0);
  }

  WriteLeftOutPhotos(field_folder / kLeftOutPhotosFile, {first.name});
  EXPECT_EQ(ReadTexturePhotos(scene_folder / "", field_folder / "").size(), 2u);
  std::vector<std::string> all;
  for (const View& view : synthetic.scene.views) all.push_back(view.name);
  WriteLeftOutPhotos(field_folder / kLeftOutPhotosFile, all);
  ExpectError<DataError>([&] { ReadTexturePhotos(scene_folder / "", field_folder / ""); },
                         {"left_out.json: names all training views", "tetrec-optimize"});
  std::filesystem::remove(field_folder / kLeftOutPhotosFile);

  const Image small = MakeImage(5, 4, 3);
  WriteImage(scene_folder / first.image, small);
  ExpectError<DataError>([&] { ReadTexturePhotos(scene_folder / "", field_folder / ""); },
                         {"5 x 4", "64 x 64"});
  WriteImage(scene_folder / first.image, MakeImage(64, 64, 3));
  ExpectError<DataError>([&] { ReadTexturePhotos(scene_folder / "", field_folder / ""); },
                         {"no alpha"});
}

}  // namespace
}  // namespace tetrec
