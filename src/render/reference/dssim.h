// D-SSIM of two images and its gradient, in double on the CPU.
#pragma once

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

struct Dssim {
  double value = 0;                  // mean over full windows and channels of (1 - SSIM) / 2
  std::vector<glm::dvec3> gradient;  // (height x width) dvalue/dshown
};

// Both images are (height x width), at least 11 x 11; see LossOptions. Pixels that are not judged
// are kNotJudged (shared/ssim.glsl.h) in both; their gradient is 0.
Dssim EvaluateDssim(std::span<const glm::dvec3> shown, std::span<const glm::dvec3> wanted,
                    int width, int height);

}  // namespace tetrec
