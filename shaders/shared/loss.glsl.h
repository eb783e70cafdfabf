// The loss of one channel, or of the opacity, of one ray.
#ifndef TETREC_LOSS_GLSL_H_
#define TETREC_LOSS_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

#define kLossL2 0
#define kLossL1 1
#define kLossSignedL2 2

TETREC_BEGIN

// A target brighter than its alpha is not a premultiplied colour: it marks a pixel that is not
// judged.
TETREC_FN bool IsJudged(Real target, Real target_alpha) { return target <= target_alpha; }

// The image is color + transmittance background; the target, premultiplied by its alpha, is
// composited on the same background. 0 for a pixel that is not judged.
TETREC_FN Real ResidualOf(Real color, Real transmittance, Real target, Real target_alpha,
                          Real background) {
  if (!IsJudged(target, target_alpha)) return Real(0.0);
  return color - target + (transmittance - (Real(1.0) - target_alpha)) * background;
}

// How much more than its target a ray lets through. 0 for a pixel that is not judged.
TETREC_FN Real TransmittanceResidual(Real transmittance, Real target, Real target_alpha) {
  return IsJudged(target, target_alpha) ? transmittance - (Real(1.0) - target_alpha) : Real(0.0);
}

// The square for L2, with the residual's sign for signed L2; the absolute value for L1.
TETREC_FN Real LossOf(int loss, Real residual) {
  if (loss == kLossL2) return residual * residual;
  Real size = residual < Real(0.0) ? -residual : residual;
  return loss == kLossL1 ? size : residual * size;
}

// dloss/dresidual; 0 where the derivative of L1 does not exist.
TETREC_FN Real LossSlope(int loss, Real residual) {
  if (loss == kLossL2) return Real(2.0) * residual;
  if (loss == kLossSignedL2) return Real(2.0) * (residual < Real(0.0) ? -residual : residual);
  if (residual == Real(0.0)) return Real(0.0);
  return residual < Real(0.0) ? Real(-1.0) : Real(1.0);
}

TETREC_END

#endif  // TETREC_LOSS_GLSL_H_
