// Renders views of a finished field and stores the ground truth beside them.
#pragma once

#include "core/stage.h"
#include "core/words.h"
#include "render/renderer.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace tetrec {

// Whether views are rendered from refined cameras, too.
enum class RefineCameras {
  kAuto,  // if the run corrected its training cameras
  kOn,
  kOff,
};
template <>
inline constexpr auto kWords<RefineCameras> = std::to_array<Word<RefineCameras>>(
    {{RefineCameras::kAuto, "auto"}, {RefineCameras::kOn, "on"}, {RefineCameras::kOff, "off"}});

struct RenderViewsOptions {
  std::string views = "heldout";     // heldout, train, all
  int samples = 2;                   // samples x samples rays per pixel
  std::string background = "scene";  // scene (the scene's own), white or black
  RefineCameras refine_cameras = RefineCameras::kAuto;
  RendererOptions renderer;
};

// The views and the background that these options mean.
std::vector<int> ChooseViews(const Scene& scene, const std::string& choice);
Background ChooseBackground(const Scene& scene, const std::string& choice);

// The options of a renderer of this mesh, which checks its rays, and accepts the tets inside out
// that motion by the article's method may have left; with a warning.
RendererOptions RendererFor(const TetMesh& mesh, const RendererOptions& options, Stage& stage);

// Writes renders/NAME.png, depth/NAME.exr (Renderer::RenderDepth, in world units),
// normals/NAME.exr (of that depth, in the world frame, towards the camera), gt/NAME.png (over the
// same background), masks/NAME.png if the scene has alpha or seen/NAME.png if it has masks,
// refined/NAME.png if cameras are refined (FitPose, to the true image and its exposure, with the
// field as it is; renders/NAME.png stays that of the scene's own camera), and views.json, which
// lists them with the protocol (run/rendered_views.h).
void RunRenderViews(const RenderViewsOptions& options, Stage& stage);

}  // namespace tetrec
