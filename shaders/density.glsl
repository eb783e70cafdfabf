// Density as a function of its parameter, by the activation of the field that a kernel is for.
#include "shared/activation.glsl.h"

layout(constant_id = kConstantDensityActivation) const int kDensityActivation = kActivationExp;

float DensityOfParameter(float parameter, float scale) {
  return ActivatedValue(kDensityActivation, parameter, scale);
}

// The derivative of density by its parameter.
float SlopeOfDensity(float parameter, float scale) {
  return ActivationSlope(kDensityActivation, parameter, scale);
}
