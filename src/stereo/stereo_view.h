// A training view as stereo sees it: grey, small, with its camera.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/image.h"
#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

// What a pixel's alpha says about the scene behind it.
enum class PixelKind : uint8_t {
  kSeen,   // shows the scene
  kEmpty,  // shows the background: nothing is in front of it (alpha of a masked subject)
  kOther,  // shows something that is not modelled (outside of a scene's masks)
};

struct StereoView {
  uint32_t view = 0;  // index into Scene::views
  Camera camera;      // of the reduced image
  Rigid3 cam_from_world;
  Image image;                   // RGB or RGBA, reduced
  std::vector<float> grey;       // height x width, luma of display sRGB in [0, 1]
  std::vector<PixelKind> kinds;  // height x width

  size_t Index(int x, int y) const { return size_t(y) * size_t(camera.width) + size_t(x); }
};

// `image` has the size of the camera, and alpha if the scene has alpha or masks. The result's
// longer side has at most `max_size` pixels.
StereoView MakeStereoView(const Scene& scene, uint32_t view, const Image& image, int max_size);

// Reads all training views of a scene folder, in parallel. Throws DataError if an image differs
// from its camera in size.
std::vector<StereoView> ReadStereoViews(const std::filesystem::path& folder, const Scene& scene,
                                        int max_size);

}  // namespace tetrec
