// Held-out views that are watched while a field is fitted.
#pragma once

#include "render/renderer.h"
#include "scene/scene.h"

#include <filesystem>
#include <vector>

namespace tetrec {

// Views and what shows them.
struct WatchedViews {
  Renderer& renderer;
  const std::filesystem::path& scene_folder;
  const Scene& scene;
  std::vector<int> views;
};

// `count` views, evenly chosen: validation views if there are any, because test views are for the
// end; otherwise held-out ones.
std::vector<int> ChooseWatchedViews(const Scene& scene, int count);

// Mean over the views of the PSNR of 8-bit images, RGB over the background, 4 rays per pixel, with
// the field that the renderer has.
double WatchPsnr(const WatchedViews& watched);

}  // namespace tetrec
