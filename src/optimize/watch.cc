// Held-out views that are watched while a field is fitted.
#include "optimize/watch.h"

#include "image/image.h"
#include "image/psnr.h"
#include "optimize/training_set.h"
#include "render/picture.h"

#include <algorithm>
#include <optional>

namespace tetrec {

std::vector<int> ChooseWatchedViews(const Scene& scene, int count) {
  std::vector<int> all = scene.ViewsOf(Split::kValidation);
  if (all.empty()) all = scene.HeldOutViews();
  std::vector<int> chosen;
  const int n = std::min<int>(count, int(all.size()));
  for (int i = 0; i < n; ++i) chosen.push_back(all[size_t(i) * all.size() / n]);
  return chosen;
}

double WatchPsnr(const WatchedViews& watched) {
  const Scene& scene = watched.scene;
  double sum = 0;
  size_t judged_views = 0;
  for (int view : watched.views) {
    const Image stored = ReadImage(watched.scene_folder / scene.views[view].image);
    const bool is_masked = scene.has_masks && stored.channels == 4;
    const Image truth = OverBackground(stored, scene.background);
    const Image picture =
        ToPicture(watched.renderer.Render(MakeRenderView(scene, view), 2), scene.background);
    const std::optional<double> mse = is_masked
                                          ? MaskedMeanSquaredError(picture, truth, MaskOf(stored))
                                          : MeanSquaredError(picture, truth);
    if (!mse) continue;
    sum += CappedPsnrFromMse(*mse);
    ++judged_views;
  }
  return judged_views == 0 ? 0 : sum / double(judged_views);
}

}  // namespace tetrec
