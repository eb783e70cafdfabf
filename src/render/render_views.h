// Renders views of a finished field and stores the ground truth beside them.
#pragma once

#include "core/stage.h"
#include "render/renderer.h"

#include <string>

namespace tetrec {

struct RenderViewsOptions {
  std::string views = "heldout";     // heldout, train, all
  int samples = 2;                   // samples x samples rays per pixel
  std::string background = "scene";  // scene (the scene's own), white or black
  RendererOptions renderer;
};

// Writes renders/NAME.png, depth/NAME.exr (Renderer::RenderDepth, in world units), gt/NAME.png
// (over the same background), masks/NAME.png if the scene has alpha or seen/NAME.png if it has
// masks, and views.json, which lists them with the protocol (run/rendered_views.h).
void RunRenderViews(const RenderViewsOptions& options, Stage& stage);

}  // namespace tetrec
