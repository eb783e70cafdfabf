// The loss that a field is fitted by.
#pragma once

#include <string>

namespace tetrec {

// The mean over rays and channels of a function of the residual. Shaders use the numbers (kLoss...
// of shared/loss.glsl.h).
enum class LossKind {
  kL2,  // the square
  kL1,  // the absolute value
  // The square, with the residual's sign. Nothing is fitted by it: its gradients by colours are the
  // absolute values of those of L2, for each ray and tet, so that they do not cancel in sums.
  kSignedL2,
};

// (1 - dssim) x pixel loss + dssim x D-SSIM, D-SSIM = (1 - SSIM) / 2, between 0 and 1. (Kerbl et
// al. 2023 mix l1 and D-SSIM like this, with weight 0.2; their published code omits the half.) SSIM
// is that of the eval module (image_metrics.h), over the windows of 11 x 11 pixels inside a batch's
// tiles; pixels nearer than 5 to a tile's border count in the windows that contain them, but are
// not the centre of one.
struct LossOptions {
  LossKind pixel = LossKind::kL2;
  double dssim = 0;  // 0 .. 1
};

// "l1" or "l2", or either and "+dssim:W" with 0 < W <= 1. Throws UsageError.
LossOptions ParseLoss(const std::string& words);

// The words for a loss.
std::string Name(const LossOptions& loss);

}  // namespace tetrec
