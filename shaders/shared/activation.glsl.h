// How the parameter that is learned becomes the value that is rendered.
#ifndef TETREC_ACTIVATION_GLSL_H_
#define TETREC_ACTIVATION_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

// As Activation of field/layout.h.
#define kActivationIdentity 0
#define kActivationColor 1
#define kActivationExp 2
#define kActivationSigned 3
#define kActivationSoftplus 4

TETREC_BEGIN

// ln(1 + x) for x in [0, 1].
#ifdef __cplusplus
TETREC_FN Real LogOfOnePlus(Real x) { return log1p(x); }
#else
float LogOfOnePlus(float x) {  // by its series where 1 + x would be rounded
  return x < 0.01 ? x * (1.0 - x * (0.5 - x * (1.0 / 3.0))) : log(1.0 + x);
}
#endif

// ln(1 + e^x), without overflow.
TETREC_FN Real Softplus(Real x) {
  Real of_other_sign = x > Real(0.0) ? -x : x;
  return LogOfOnePlus(exp(of_other_sign)) + (x > Real(0.0) ? x : Real(0.0));
}

TETREC_FN Real ActivatedValue(int activation, Real parameter, Real scale) {
  if (activation == kActivationExp) return exp(parameter);
  if (activation == kActivationSigned) return scale * sinh(parameter);
  if (activation == kActivationSoftplus) return scale * Softplus(parameter);
  return parameter;
}

// The derivative of ActivatedValue by the parameter.
TETREC_FN Real ActivationSlope(int activation, Real parameter, Real scale) {
  if (activation == kActivationExp) return exp(parameter);
  if (activation == kActivationSigned) return scale * cosh(parameter);
  if (activation == kActivationSoftplus) return scale / (Real(1.0) + exp(-parameter));
  return Real(1.0);
}

TETREC_END

#endif  // TETREC_ACTIVATION_GLSL_H_
