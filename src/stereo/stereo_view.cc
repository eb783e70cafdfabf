// A training view as stereo sees it.
#include "stereo/stereo_view.h"

#include "core/error.h"
#include "core/parallel.h"
#include "image/luma.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

PixelKind KindOf(const Scene& scene, const Image& image, const uint8_t* pixel) {
  if (image.channels < 4 || pixel[3] >= kSeenAlpha) return PixelKind::kSeen;
  return scene.has_masks ? PixelKind::kOther : PixelKind::kEmpty;
}

}  // namespace

StereoView MakeStereoView(const Scene& scene, uint32_t view, const Image& image, int max_size) {
  const Camera& camera = scene.cameras[size_t(scene.views[view].camera)];
  if (image.width != camera.width || image.height != camera.height) {
    throw DataError(fmt::format("{}: {} x {} pixels; its camera has {} x {}",
                                scene.views[view].image, image.width, image.height, camera.width,
                                camera.height));
  }
  const double shrink = std::min(1.0, double(max_size) / std::max(camera.width, camera.height));
  const int width = std::max(2, int(std::lround(camera.width * shrink)));
  const int height = std::max(2, int(std::lround(camera.height * shrink)));
  StereoView result;
  result.view = view;
  result.camera = camera.Resized(width, height);
  result.cam_from_world = scene.views[view].cam_from_world;
  result.image = shrink < 1 ? ResizeByArea(image, width, height) : image;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const uint8_t* pixel = result.image.At(x, y);
      result.grey.push_back(Luma(pixel));
      result.kinds.push_back(KindOf(scene, result.image, pixel));
    }
  }
  return result;
}

std::vector<StereoView> ReadStereoViews(const std::filesystem::path& folder, const Scene& scene,
                                        int max_size) {
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  std::vector<StereoView> views(training.size());
  ParallelFor(training.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t view = uint32_t(training[i]);
      views[i] = MakeStereoView(scene, view, ReadImage(folder / scene.views[view].image), max_size);
    }
  });
  return views;
}

}  // namespace tetrec
