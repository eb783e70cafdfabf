#include "optimize/watch.h"

#include "image/psnr.h"
#include "optimize/wavy_box.h"
#include "render/create_renderer.h"
#include "render/picture.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(ThinnedCamera, HasItsPixelsInEveryNthRowAndColumn) {
  const Camera camera{31, 20, 40.0, 42.0, 15.2, 9.7};
  for (const int stride : {1, 2, 3, 4}) {
    const Camera thinned = ThinnedCamera(camera, stride, {0.25, 0.75});
    const int first = (stride - 1) / 2;
    EXPECT_LT(first + stride * (thinned.width - 1), camera.width);
    EXPECT_GE(first + stride * thinned.width, camera.width);
    EXPECT_GE(first + stride * thinned.height, camera.height);
    for (const glm::ivec2 pixel : {glm::ivec2(0, 0), glm::ivec2(3, 2)}) {
      // The same point is in the middle of the one's pixel and at the place in the other's.
      const glm::dvec3 point((pixel.x + 0.5 - thinned.cx) / thinned.fx,
                             (pixel.y + 0.5 - thinned.cy) / thinned.fy, 1.0);
      const glm::dvec2 seen = camera.ImageFromCam(point);
      EXPECT_NEAR(seen.x, first + stride * pixel.x + 0.25, 1e-9);
      EXPECT_NEAR(seen.y, first + stride * pixel.y + 0.75, 1e-9);
    }
  }
}

TEST(ThinnedCamera, StaysInAPictureThatIsLowerThanTheStride) {
  const Camera thinned = ThinnedCamera({100, 2, 50.0, 50.0, 50.0, 1.0}, 9, {0.5, 0.5});
  EXPECT_EQ(thinned.height, 1);
  EXPECT_NEAR((0.5 - thinned.cy) / thinned.fy, (0.5 - 1.0) / 50.0, 1e-12);  // row 0
}

// Photos that are pictures of the field itself, so that a pixel in the wrong place is a loss.
struct WatchedBox {
  WatchedBox() {
    renderer->SetField(WavyBox(0.4, 20.0f));
    for (const RenderView& ring : Ring(3)) {
      scene.cameras.push_back(ring.camera);
      View view;
      view.camera = int(scene.cameras.size()) - 1;
      view.cam_from_world = ring.cam_from_world;
      view.image = std::to_string(scene.views.size()) + ".png";
      WriteImage(folder / view.image, ToPicture(renderer->Render(ring, 2), scene.background));
      scene.views.push_back(view);
    }
  }

  ScratchFolder folder;
  Scene scene;
  std::unique_ptr<ProbedRenderer> renderer =
      CreateProbedRenderer({.kind = RendererKind::kReference});
  WatchedViews watched{*renderer, folder.path(), scene, {0, 1, 2}};
};

TEST(WatchPsnr, ComparesTheSamePixelsOfPhotosAndPictures) {
  const WatchedBox box;
  EXPECT_EQ(WatchPsnr(box.watched), kPsnrCap_db);
  // Rounding may change a pixel by one step of 255.
  for (const int stride : {2, 3, 5}) EXPECT_GT(WatchPsnr(box.watched, stride), 60.0) << stride;
}

// The mask is grey on the left, and hides the right, where the photo is of another colour.
TEST(WatchPsnr, AGreyMaskDarkensNoPhoto) {
  WatchedBox box;
  box.scene.has_masks = true;
  for (const View& view : box.scene.views) {
    const Image photo = ReadImage(box.folder / view.image);
    Image masked = MakeImage(photo.width, photo.height, 4);
    for (int y = 0; y < photo.height; ++y) {
      for (int x = 0; x < photo.width; ++x) {
        const bool is_hidden = 2 * x > photo.width;
        for (int c = 0; c < 3; ++c) {
          masked.At(x, y)[c] = is_hidden ? uint8_t(255 - photo.At(x, y)[c]) : photo.At(x, y)[c];
        }
        masked.At(x, y)[3] = is_hidden ? kSeenAlpha - 1 : kSeenAlpha;
      }
    }
    WriteImage(box.folder / view.image, masked);
  }
  EXPECT_EQ(WatchPsnr(box.watched), kPsnrCap_db);
}

TEST(WatchPsnr, IsNearThatOfAllPixels) {
  const WatchedBox box;
  box.renderer->SetField(WavyBox(0.2, 20.0f));
  const double all = WatchPsnr(box.watched);
  EXPECT_LT(all, 40.0);
  for (const int stride : {2, 3}) EXPECT_NEAR(WatchPsnr(box.watched, stride), all, 0.5) << stride;
}

TEST(StrideFor, LeavesNoMorePixelsThanAskedFor) {
  const WatchedBox box;
  const Camera& camera = box.scene.cameras[0];
  const uint64_t all = 3 * uint64_t(camera.width) * uint64_t(camera.height);
  EXPECT_EQ(StrideFor(box.watched, all), 1);
  EXPECT_EQ(StrideFor(box.watched, all - 1), 2);
  const int stride = StrideFor(box.watched, all / 10);
  EXPECT_GE(stride, 4);
  EXPECT_LE(stride, 5);
  EXPECT_GT(StrideFor(box.watched, 0), 1);  // a pixel of each view remains
}

}  // namespace
}  // namespace tetrec
