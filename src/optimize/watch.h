// Held-out views that are watched while a field is fitted.
#pragma once

#include "render/renderer.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
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
// the field that the renderer has. Only pixels in every `stride`-th row and column are rendered.
double WatchPsnr(const WatchedViews& watched, int stride = 1);

// The least stride that leaves no more than `pixels` pixels of all watched views.
int StrideFor(const WatchedViews& watched, uint64_t pixels);

// A camera with one pixel for each pixel in every `stride`-th row and column of `camera`. Its pixel
// centres lie at `place` of those pixels, in [0, 1] from the corner.
Camera ThinnedCamera(const Camera& camera, int stride, const glm::dvec2& place);

}  // namespace tetrec
