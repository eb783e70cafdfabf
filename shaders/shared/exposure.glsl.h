// The exposure and white balance of a photo, as one gain and one offset per channel.
#ifndef TETREC_EXPOSURE_GLSL_H_
#define TETREC_EXPOSURE_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

TETREC_BEGIN

// What a photo shows of a channel of the field, in front of the background:
//   shown = gain color + offset (1 - transmittance).
// `color` is premultiplied by the opacity 1 - T, and so is the offset: the background behind the
// field is not exposed. Its derivatives are gain by color and -offset by transmittance.
TETREC_FN Real ExposedColor(Real color, Real transmittance, Real gain, Real offset) {
  return gain * color + offset * (Real(1.0) - transmittance);
}

// What ExposedColor should be so that the residual (loss.glsl.h) is 0.
TETREC_FN Real WantedColor(Real transmittance, Real target, Real target_alpha, Real background) {
  return target + (Real(1.0) - target_alpha - transmittance) * background;
}

TETREC_END

#endif  // TETREC_EXPOSURE_GLSL_H_
