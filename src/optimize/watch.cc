// Held-out views that are watched while a field is fitted.
#include "optimize/watch.h"

#include "image/image.h"
#include "image/psnr.h"
#include "optimize/training_set.h"
#include "render/picture.h"
#include "render/target_image.h"

#include <algorithm>
#include <optional>

namespace tetrec {
namespace {

constexpr int kSamples = 2;  // kSamples x kSamples rays per pixel

// The first of every stride-th row or column of a picture, and their number, which is at least 1.
int FirstOfStride(int size, int stride) { return (std::min(size, stride) - 1) / 2; }

int CountOfStride(int size, int stride) {
  return (size - FirstOfStride(size, stride) + stride - 1) / stride;
}

Image Thinned(const Image& image, int stride) {
  Image thinned = MakeImage(CountOfStride(image.width, stride), CountOfStride(image.height, stride),
                            image.channels);
  const int left = FirstOfStride(image.width, stride), top = FirstOfStride(image.height, stride);
  for (int y = 0; y < thinned.height; ++y) {
    for (int x = 0; x < thinned.width; ++x) {
      std::copy_n(image.At(left + stride * x, top + stride * y), image.channels, thinned.At(x, y));
    }
  }
  return thinned;
}

// The thinned picture, with kSamples x kSamples rays in each of its pixels.
RenderedImage RenderThinned(Renderer& renderer, const RenderView& view, int stride) {
  if (stride == 1) return renderer.Render(view, kSamples);
  constexpr int kPlaces = kSamples * kSamples;
  RenderedImage mean;
  for (int i = 0; i < kPlaces; ++i) {
    const glm::dvec2 place = (glm::dvec2(i % kSamples, i / kSamples) + 0.5) / double(kSamples);
    const RenderedImage part =
        renderer.Render({ThinnedCamera(view.camera, stride, place), view.cam_from_world}, 1);
    if (i == 0) {
      mean = {part.width, part.height, std::vector<glm::vec3>(part.color_srgb.size()),
              std::vector<float>(part.transmittance.size())};
    }
    for (size_t p = 0; p < part.transmittance.size(); ++p) {
      mean.color_srgb[p] += part.color_srgb[p] / float(kPlaces);
      mean.transmittance[p] += part.transmittance[p] / float(kPlaces);
    }
  }
  return mean;
}

}  // namespace

std::vector<int> ChooseWatchedViews(const Scene& scene, int count) {
  std::vector<int> all = scene.ViewsOf(Split::kValidation);
  if (all.empty()) all = scene.HeldOutViews();
  std::vector<int> chosen;
  const int n = std::min<int>(count, int(all.size()));
  for (int i = 0; i < n; ++i) chosen.push_back(all[size_t(i) * all.size() / n]);
  return chosen;
}

double WatchPsnr(const WatchedViews& watched, int stride) {
  const Scene& scene = watched.scene;
  double sum = 0;
  size_t judged_views = 0;
  for (int view : watched.views) {
    const Image stored = Thinned(ReadImage(watched.scene_folder / scene.views[view].image), stride);
    const bool is_masked = scene.has_masks && stored.channels == 4;
    const Image truth = TruthOf(stored, scene.has_masks, scene.background);
    const Image picture = ToPicture(
        RenderThinned(watched.renderer, MakeRenderView(scene, view), stride), scene.background);
    const std::optional<double> mse = is_masked
                                          ? MaskedMeanSquaredError(picture, truth, MaskOf(stored))
                                          : MeanSquaredError(picture, truth);
    if (!mse) continue;
    sum += CappedPsnrFromMse(*mse);
    ++judged_views;
  }
  return judged_views == 0 ? 0 : sum / double(judged_views);
}

int StrideFor(const WatchedViews& watched, uint64_t pixels) {
  const auto count = [&](int stride) {
    uint64_t sum = 0;
    for (int view : watched.views) {
      const Camera& camera = watched.scene.cameras[watched.scene.views[view].camera];
      sum += uint64_t(CountOfStride(camera.width, stride)) *
             uint64_t(CountOfStride(camera.height, stride));
    }
    return sum;
  };
  int stride = 1;
  while (count(stride) > std::max<uint64_t>(pixels, watched.views.size())) ++stride;
  return stride;
}

Camera ThinnedCamera(const Camera& camera, int stride, const glm::dvec2& place) {
  const auto moved = [&](double center, int size, double at) {
    return (center - FirstOfStride(size, stride) - at) / stride + 0.5;
  };
  return {CountOfStride(camera.width, stride),
          CountOfStride(camera.height, stride),
          camera.fx / stride,
          camera.fy / stride,
          moved(camera.cx, camera.width, place.x),
          moved(camera.cy, camera.height, place.y)};
}

}  // namespace tetrec
