// The integral over one segment with its mean density in place of the linear one, colour linear.
//
// With tau = (s0 + s1) / 2 (segment.glsl.h explains the symbols) the opacity is exact, and
//   T = e^-tau,  M = (1 - T) / tau,  w0 = 1 - M,  w1 = M - T,  w0 + w1 = 1 - T,
//   dw0/dtau = w1 / tau,  dw1/dtau = T - w1 / tau.
// Thin segments (tau < 1), where these cancel, use b(tau) = w1 / tau, a polynomial, and from it
//   w0 = int_0^tau b,  w1 = tau b,  dw0/dtau = b,  dw1/dtau = b + tau b',
// so that the derivatives are those of the weights as computed. The fit is accurate to 1e-9, its
// slope to 2e-7. In float, the relative error of the weights is 8e-7 and the absolute error of the
// derivatives 6e-7.
#ifndef TETREC_SEGMENT_MEAN_GLSL_H_
#define TETREC_SEGMENT_MEAN_GLSL_H_

#include "segment.glsl.h"

TETREC_BEGIN

// A segment of constant density: transmittance, weights, their derivatives with respect to tau.
TETREC_STRUCT ConstantSegment { Real t, w0, w1, dw0, dw1; };

// The Horner step for the k-th coefficient of b in the four series.
TETREC_FN TETREC_T(ConstantSegment)
    AddCoefficient(TETREC_T(ConstantSegment) sum, Real tau, Real coefficient, Real k) {
  sum.w0 = sum.w0 * tau + coefficient / (k + Real(1.0));
  sum.w1 = sum.w1 * tau + coefficient;
  sum.dw1 = sum.dw1 * tau + coefficient * (k + Real(1.0));
  return sum;
}

TETREC_FN TETREC_T(ConstantSegment) IntegrateThinConstantSegment(Real tau, Real t) {
  TETREC_T(ConstantSegment) sum;
  sum.t = t;
  sum.w0 = sum.w1 = sum.dw0 = sum.dw1 = Real(0.0);
  sum = AddCoefficient(sum, tau, Real(-1.49739432e-5), Real(7.0));
  sum = AddCoefficient(sum, tau, Real(1.64556984e-4), Real(6.0));
  sum = AddCoefficient(sum, tau, Real(-1.18451230e-3), Real(5.0));
  sum = AddCoefficient(sum, tau, Real(6.94239652e-3), Real(4.0));
  sum = AddCoefficient(sum, tau, Real(-3.33329957e-2), Real(3.0));
  sum = AddCoefficient(sum, tau, Real(1.24999979e-1), Real(2.0));
  sum = AddCoefficient(sum, tau, Real(-3.33333333e-1), Real(1.0));
  sum = AddCoefficient(sum, tau, Real(0.5), Real(0.0));
  sum.dw0 = sum.w1;
  sum.w0 = sum.w0 * tau;
  sum.w1 = sum.w1 * tau;
  return sum;
}

TETREC_FN TETREC_T(ConstantSegment) IntegrateThickConstantSegment(Real tau, Real t) {
  Real by_tau = Real(1.0) / tau;
  Real mean = (Real(1.0) - t) * by_tau;
  TETREC_T(ConstantSegment) result;
  result.t = t;
  result.w0 = Real(1.0) - mean;
  result.w1 = mean - t;
  result.dw0 = result.w1 * by_tau;
  result.dw1 = t - result.dw0;
  return result;
}

// tau >= 0, finite.
TETREC_FN TETREC_T(ConstantSegment) IntegrateConstantSegment(Real tau) {
  Real t = exp(-tau);
  if (tau < Real(1.0)) return IntegrateThinConstantSegment(tau, t);
  return IntegrateThickConstantSegment(tau, t);
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentWeights) IntegrateMeanSegment(Real s0, Real s1) {
  TETREC_T(ConstantSegment) segment = IntegrateConstantSegment(Real(0.5) * (s0 + s1));
  TETREC_T(SegmentWeights) result;
  result.w0 = segment.w0;
  result.w1 = segment.w1;
  return result;
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentAdjoint) IntegrateMeanSegmentWithDerivatives(Real s0, Real s1) {
  TETREC_T(ConstantSegment) segment = IntegrateConstantSegment(Real(0.5) * (s0 + s1));
  TETREC_T(SegmentAdjoint) result;
  result.w0 = segment.w0;
  result.w1 = segment.w1;
  result.dw0_ds0 = result.dw0_ds1 = Real(0.5) * segment.dw0;
  result.dw1_ds0 = result.dw1_ds1 = Real(0.5) * segment.dw1;
  return result;
}

TETREC_END

#endif  // TETREC_SEGMENT_MEAN_GLSL_H_
