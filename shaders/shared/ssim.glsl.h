// Structural similarity of two images x and y, and its derivatives.
//
// Wang, Bovik, Sheikh, Simoncelli 2004: in a Gaussian window of 11 x 11 pixels, sigma 1.5, with the
// weighted means m_x, m_y, variances v and covariance c,
//   SSIM = (2 m_x m_y + C1) (2 c + C2) / ((m_x^2 + m_y^2 + C1) (v_x + v_y + C2)),
// C1 = 0.01^2, C2 = 0.03^2 for values in [0, 1]. The variances come from the means of squares.
#ifndef TETREC_SSIM_GLSL_H_
#define TETREC_SSIM_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

TETREC_BEGIN

// The value in both images of a pixel that is not judged: practically black, and below 0, which no
// judged pixel is.
#define kNotJudged (-1e-6)

#define kSsimReach 5  // pixels of the window to either side of its centre

// Means of x, y, x^2, y^2 and x y in a window.
TETREC_STRUCT WindowMeans { Real x, y, xx, yy, xy; };

TETREC_STRUCT SsimAdjoint {
  Real value;
  Real by_x, by_xx, by_xy;  // derivatives by the window's means of x, x^2 and x y
};

// Weight of the pixel `offset` columns (or rows) from the window's centre; all add up to 1. The
// weights of the window are products of two of these.
TETREC_FN Real SsimWindowWeight(Real offset) {
  return exp(-offset * offset / Real(4.5)) / Real(3.759232795169263);
}

TETREC_FN TETREC_T(SsimAdjoint) SsimWithDerivatives(TETREC_T(WindowMeans) mean) {
  Real c1 = Real(1e-4), c2 = Real(9e-4);
  Real sizes = mean.x * mean.x + mean.y * mean.y + c1;
  Real spreads = mean.xx - mean.x * mean.x + mean.yy - mean.y * mean.y + c2;
  Real light = (Real(2.0) * mean.x * mean.y + c1) / sizes;
  Real structure = (Real(2.0) * (mean.xy - mean.x * mean.y) + c2) / spreads;
  TETREC_T(SsimAdjoint) ssim;
  ssim.value = light * structure;
  ssim.by_x = Real(2.0) * (structure * (mean.y - mean.x * light) / sizes +
                           light * (mean.x * structure - mean.y) / spreads);
  ssim.by_xx = -light * structure / spreads;
  ssim.by_xy = Real(2.0) * light / spreads;
  return ssim;
}

TETREC_END

#endif  // TETREC_SSIM_GLSL_H_
