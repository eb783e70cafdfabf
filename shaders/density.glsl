// Density as a function of its parameter (Activation of field/layout.h).

layout(constant_id = kConstantDensityActivation) const int kDensityActivation = kActivationExp;

// ln(1 + e^x). Where 1 + e^x would be rounded, by its series.
float Softplus(float x) {
  float e = exp(-abs(x));
  float of_small = e < 0.01 ? e * (1.0 - e * (0.5 - e * (1.0 / 3.0))) : log(1.0 + e);
  return max(x, 0.0) + of_small;
}

float DensityOfParameter(float parameter, float scale) {
  if (kDensityActivation == kActivationSigned) return scale * sinh(parameter);
  if (kDensityActivation == kActivationSoftplus) return scale * Softplus(parameter);
  return exp(parameter);
}

// The derivative of density by its parameter.
float SlopeOfDensity(float parameter, float scale) {
  if (kDensityActivation == kActivationSigned) return scale * cosh(parameter);
  if (kDensityActivation == kActivationSoftplus) return scale / (1.0 + exp(-parameter));
  return exp(parameter);
}
