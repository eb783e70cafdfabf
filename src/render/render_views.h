// Pictures of a finished field, beside the ground truth.
#pragma once

#include "core/stage.h"
#include "render/renderer.h"

#include <string>

namespace tetrec {

struct RenderViewsOptions {
  std::string views = "heldout";     // heldout, train, all
  int samples = 2;                   // samples x samples rays a pixel
  std::string background = "scene";  // scene: the scene's own; or white, black
  RendererOptions renderer;
};

// Writes renders/NAME.png, gt/NAME.png (composited over the same background), masks/NAME.png where
// the pictures have alpha, and views.json that lists them with the protocol.
void RunRenderViews(const RenderViewsOptions& options, Stage& stage);

}  // namespace tetrec
