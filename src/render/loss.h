// Which loss a field is fitted by.
#pragma once

#include <string>

namespace tetrec {

// Mean over rays and channels of squares or of absolute values.
enum class LossKind { kL2, kL1 };

// (1 - dssim) x pixel loss + dssim x D-SSIM, D-SSIM = (1 - SSIM) / 2, between 0 and 1. (Kerbl et
// al. 2023 mix l1 with D-SSIM so, weight 0.2; their published code leaves the half out.) SSIM is
// that of the eval module (image_metrics.h), of the windows of 11 x 11 pixels that lie inside a
// batch's tiles; pixels nearer to a tile's border than 5 count in the windows that hold them, and
// have none of their own.
struct LossOptions {
  LossKind pixel = LossKind::kL2;
  double dssim = 0;  // 0 .. 1
};

// "l1" or "l2", or either and "+dssim:W" with 0 < W <= 1. Throws UsageError.
LossOptions ParseLoss(const std::string& words);

}  // namespace tetrec
