// The pose of one view fitted to its picture while the field stays as it is.
#pragma once

#include "geometry/small_motion.h"
#include "render/exposure.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>

namespace tetrec {

// A view and what it should show.
struct PoseTask {
  RenderView view;  // where the fit starts
  Rigid3
      given_cam_from_world;   // where the camera was found; what the photo leaves open stays there
  const TargetImage& target;  // kNotJudgedTarget: not looked at
  // How the view shows the field; if there is none, it is fitted to the same pixels.
  std::optional<ViewExposure> exposure;
  glm::vec3 background_srgb{0.0f};  // behind field and target
};

struct PoseFitOptions {
  int pixels = 1024;   // about as many are fitted to, and as many others decide
  int iterations = 1;  // steps of Gauss and Newton
  uint64_t seed = 1;   // of the choice of pixels
};

struct PoseFit {
  Rigid3 cam_from_world;   // that of the task unless a better one was found
  bool is_better = false;  // on pixels that it was not fitted to
  double depth = 0;        // median over the pixels [world units]; 0 if the view shows nothing
};

// Steps of Gauss and Newton on Huber's cost of the residuals at a lattice of pixels (Huber 1964),
// with derivatives by central differences that move the picture by half a pixel to either side.
// Each of the six numbers of the correction, in pixels, is pulled towards 0 as if it had a standard
// deviation of 2 px. The result counts only if it lowers the cost on another lattice by more than
// twice the standard error of the difference, and by enough to matter.
PoseFit FitPose(Renderer& renderer, const PoseTask& task, const PoseFitOptions& options);

}  // namespace tetrec
