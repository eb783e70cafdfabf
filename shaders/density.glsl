// Density as a function of its parameter (Activation of field/layout.h).

layout(constant_id = kConstantSignedDensity) const int kSignedDensity = 0;

float DensityOfParameter(float parameter, float scale) {
  if (kSignedDensity != 0) return scale * sinh(parameter);
  return exp(parameter);
}

// The derivative of density by its parameter.
float SlopeOfDensity(float parameter, float scale) {
  if (kSignedDensity != 0) return scale * cosh(parameter);
  return exp(parameter);
}
