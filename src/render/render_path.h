// Renders a finished field along a path of the camera, to a video.
#pragma once

#include "core/stage.h"
#include "render/camera_path.h"
#include "render/render_views.h"

namespace tetrec {

struct RenderPathOptions {
  CameraPath path = CameraPath::kNone;
  double seconds = 8;  // length of the video
  int frames = 0;      // instead of `seconds`; 0: seconds x fps
  double fps = 25;
  int size = 0;  // longer side of the video [px]; 0: as the scene's images

  void Check() const;  // throws UsageError naming the option and its value
  size_t FrameCount() const;
};

// Writes video.mp4 (H.264, by ffmpeg as a child process). `views`: the background, the rays per
// pixel and the renderer, and of which cameras the path is made. Throws EnvironmentError without
// ffmpeg, before anything is rendered.
void RunRenderPath(const RenderPathOptions& options, const RenderViewsOptions& views, Stage& stage);

}  // namespace tetrec
