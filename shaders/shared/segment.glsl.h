// The emission-absorption integral over one segment of a ray, density and colour linear along it.
//
// A segment of true length l has end densities a0, a1; s0 = a0 l and s1 = a1 l are the inputs here.
// tau(s) = s0 s + (s1 - s0) s^2 / 2, T = e^(-(s0 + s1) / 2), M = int_0^1 e^(-tau(s)) ds. Then
//   C = c0 w0 + c1 w1,  w0 = 1 - M,  w1 = M - T,  opacity 1 - T = w0 + w1
// (integration by parts of int_0^1 tau'(s) e^(-tau(s)) ((1 - s) c0 + s c1) ds).
//
// Thin segments (tau < kSegmentSwitch): as density is linear, everything follows from three
// moments,
//   E0 = int (1-s)^2 e^(-tau(s)) ds, E1 = int s (1-s) e^(-tau(s)) ds, E2 = int s^2 e^(-tau(s)) ds:
//   w0 = s0 E0 + s1 E1, w1 = s0 E1 + s1 E2, int s e^(-tau) = E1 + E2, T = 1 - w0 - w1,
// sums of positive terms that do not cancel. With y = s - 1/2, m = (s0 + s1) / 2, p = (s1 - s0) / 2
//   e^(-tau(s)) = e^(-tau(1/2)) e^(-m y - p y^2),  e^(-m y) = cosh my - sinh my,
// integrated by seven-point Gauss-Legendre, nodes in pairs, with short series for cosh, sinh and
// exp: one true exponential per segment. Relative error in float: 9e-7.
//
// Thick segments: M has a closed form,
//   s1 > s0: M = sqrt(pi / 2D) [erfcx(x0) - T erfcx(x1)],  s1 < s0: M = sqrt(2 / D) [F(x0) - T
//   F(x1)]
// with D = |s1 - s0|, x_i = s_i / sqrt(2 D), F Dawson's integral. Relative error in float: 8e-7.
#ifndef TETREC_SEGMENT_GLSL_H_
#define TETREC_SEGMENT_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

TETREC_BEGIN

#define kSegmentSwitch Real(2.5)

TETREC_STRUCT SegmentWeights {
  Real w0, w1;  // weights of the colours at entry and exit
};

// int (1-s)^2 e^(-tau), int s (1-s) e^(-tau), int s^2 e^(-tau) over the segment.
TETREC_STRUCT SegmentMoments { Real e0, e1, e2; };

// The weights and their derivatives with respect to s0 and s1; dT/ds0 = dT/ds1 = -T / 2.
TETREC_STRUCT SegmentAdjoint {
  Real w0, w1;
  Real dw0_ds0, dw0_ds1, dw1_ds0, dw1_ds1;
};

// e^(x^2) erfc(x) for x >= 0. (1 + 2x) times it is a polynomial of degree 10 in (x - 3) / (x + 3);
// relative error 4e-7.
TETREC_FN Real Erfcx(Real x) {
  Real q = (x - Real(3.0)) / (x + Real(3.0));
  Real p = Real(-9.25838524e-5);
  p = p * q + Real(-0.000513869856);
  p = p * q + Real(0.00187516617);
  p = p * q + Real(0.00228655239);
  p = p * q + Real(-0.0237636441);
  p = p * q + Real(0.0684095563);
  p = p * q + Real(-0.119275254);
  p = p * q + Real(0.129627511);
  p = p * q + Real(-0.0475621592);
  p = p * q + Real(-0.135620239);
  p = p * q + Real(1.25300806);
  return p / (Real(1.0) + Real(2.0) * x);
}

// Dawson's integral e^(-x^2) int_0^x e^(t^2) dt for x >= 0; relative error 4e-7.
TETREC_FN Real Dawson(Real x) {
  if (x < Real(4.0)) {
    Real y = x * x;
    Real p = Real(1.82589851e-8);
    p = p * y + Real(8.56536889e-6);
    p = p * y + Real(0.000231729501);
    p = p * y + Real(0.000521988282);
    p = p * y + Real(0.0366616396);
    p = p * y + Real(-0.0591804427);
    p = p * y + Real(0.999999984);
    Real r = Real(2.04960576e-5);
    r = r * y + Real(0.000319257338);
    r = r * y + Real(0.00384882029);
    r = r * y + Real(0.0313637069);
    r = r * y + Real(0.174989888);
    r = r * y + Real(0.607485566);
    r = r * y + Real(1.0);
    return x * p / r;
  }
  Real z = Real(1.0) / (x * x);
  Real p = Real(148.414002);
  p = p * z + Real(-5.30736429);
  p = p * z + Real(2.33894907);
  p = p * z + Real(0.742289927);
  p = p * z + Real(0.500045619);
  p = p * z + Real(0.999999957);
  return p / (Real(2.0) * x);
}

// M for tau >= kSegmentSwitch; t is the segment's transmittance.
TETREC_FN Real SegmentMeanClosed(Real s0, Real s1, Real t) {
  Real d = s1 - s0;
  Real size = d < Real(0.0) ? -d : d;
  Real largest = s0 < s1 ? s1 : s0;
  // With equal densities the arguments of the fits would go to infinity; the error of the mean is
  // of order d.
  if (size <= Real(1e-7) * largest) return (Real(1.0) - t) / (Real(0.5) * (s0 + s1));
  Real scale = Real(1.0) / sqrt(Real(2.0) * size);
  if (d > Real(0.0)) {
    return Real(1.7724538509055159) * scale * (Erfcx(s0 * scale) - t * Erfcx(s1 * scale));
  }
  return Real(2.0) * scale * (Dawson(s0 * scale) - t * Dawson(s1 * scale));
}

// Adds the nodes y and -y of [-1/2, 1/2] with weight g to sums of f, y f and y^2 f, where
// f = e^(-m y - p y^2). With |m y| < 1.19, |p y^2| < 0.57 the series are cut off below 2e-8.
TETREC_FN TETREC_T(SegmentMoments)
    AddNodePair(TETREC_T(SegmentMoments) sum, Real m, Real p, Real y, Real g) {
  Real u = m * m * (y * y);
  Real cosh_my = u * Real(2.75573192e-7) + Real(2.48015873e-5);
  cosh_my = cosh_my * u + Real(1.38888889e-3);
  cosh_my = cosh_my * u + Real(4.16666667e-2);
  cosh_my = cosh_my * u + Real(0.5);
  cosh_my = cosh_my * u + Real(1.0);
  Real sinh_over_my = u * Real(2.50521084e-8) + Real(2.75573192e-6);
  sinh_over_my = sinh_over_my * u + Real(1.98412698e-4);
  sinh_over_my = sinh_over_my * u + Real(8.33333333e-3);
  sinh_over_my = sinh_over_my * u + Real(1.66666667e-1);
  sinh_over_my = sinh_over_my * u + Real(1.0);
  Real v = p * (-y * y);
  Real e = v * Real(2.48015873e-5) + Real(1.98412698e-4);
  e = e * v + Real(1.38888889e-3);
  e = e * v + Real(8.33333333e-3);
  e = e * v + Real(4.16666667e-2);
  e = e * v + Real(1.66666667e-1);
  e = e * v + Real(0.5);
  e = e * v + Real(1.0);
  e = e * v + Real(1.0);
  Real even = (Real(2.0) * g) * (e * cosh_my);
  sum.e0 = sum.e0 + even;
  sum.e1 = sum.e1 - (Real(2.0) * g * y * y) * (e * sinh_over_my) * m;
  sum.e2 = sum.e2 + (y * y) * even;
  return sum;
}

// Moments of a thin segment, tau < kSegmentSwitch.
TETREC_FN TETREC_T(SegmentMoments) ThinSegmentMoments(Real s0, Real s1) {
  Real m = Real(0.5) * (s0 + s1);
  Real p = Real(0.5) * (s1 - s0);
  TETREC_T(SegmentMoments) sum;        // of f, y f, y^2 f
  sum.e0 = Real(0.20897959183673469);  // the node y = 0
  sum.e1 = Real(0.0);
  sum.e2 = Real(0.0);
  sum = AddNodePair(sum, m, p, Real(0.47455395617137926), Real(0.064742483084434846));
  sum = AddNodePair(sum, m, p, Real(0.37076559279969724), Real(0.13985269574463833));
  sum = AddNodePair(sum, m, p, Real(0.20292257568869859), Real(0.19091502525255947));
  Real middle = exp(-(Real(0.5) * m - Real(0.25) * p));
  Real quarter = Real(0.25) * sum.e0;
  TETREC_T(SegmentMoments) moments;
  moments.e0 = middle * (sum.e2 - sum.e1 + quarter);
  moments.e1 = middle * (quarter - sum.e2);
  moments.e2 = middle * (sum.e2 + sum.e1 + quarter);
  return moments;
}

TETREC_FN bool IsThinSegment(Real s0, Real s1) { return Real(0.5) * (s0 + s1) < kSegmentSwitch; }

TETREC_FN TETREC_T(SegmentWeights) IntegrateThinSegment(Real s0, Real s1) {
  TETREC_T(SegmentMoments) moments = ThinSegmentMoments(s0, s1);
  TETREC_T(SegmentWeights) result;
  result.w0 = s0 * moments.e0 + s1 * moments.e1;
  result.w1 = s0 * moments.e1 + s1 * moments.e2;
  return result;
}

TETREC_FN TETREC_T(SegmentWeights) IntegrateThickSegment(Real s0, Real s1) {
  Real t = exp(-(Real(0.5) * (s0 + s1)));
  Real mean = SegmentMeanClosed(s0, s1, t);
  TETREC_T(SegmentWeights) result;
  result.w0 = Real(1.0) - mean;
  result.w1 = mean - t;
  return result;
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentWeights) IntegrateSegment(Real s0, Real s1) {
  if (IsThinSegment(s0, s1)) return IntegrateThinSegment(s0, s1);
  return IntegrateThickSegment(s0, s1);
}

// The share of the segment, in [0, 1], at which its optical depth has reached `tau`: the root of
// s0 u + (s1 - s0) u^2 / 2 = tau, in the form that does not cancel. s0, s1 >= 0, finite;
// 0 <= tau <= (s0 + s1) / 2.
TETREC_FN Real ReachInSegment(Real s0, Real s1, Real tau) {
  Real inside = s0 * s0 + Real(2.0) * (s1 - s0) * tau;
  Real root = Real(0.0);
  if (inside > Real(0.0)) root = sqrt(inside);
  Real sum = s0 + root;
  if (!(sum > Real(0.0))) return Real(0.0);
  Real share = Real(2.0) * tau / sum;
  if (share > Real(1.0)) return Real(1.0);
  return share;
}

// Adds the Gauss-Legendre node s with weight g.
TETREC_FN TETREC_T(SegmentMoments)
    AddMomentNode(TETREC_T(SegmentMoments) sum, Real s0, Real s1, Real s, Real g) {
  Real e = g * exp(-(s * (s0 + Real(0.5) * (s1 - s0) * s)));
  sum.e0 = sum.e0 + (Real(1.0) - s) * (Real(1.0) - s) * e;
  sum.e1 = sum.e1 + s * (Real(1.0) - s) * e;
  sum.e2 = sum.e2 + s * s * e;
  return sum;
}

// Adds the nodes s and 1 - s of [0, 1], scaled to [0, end].
TETREC_FN TETREC_T(SegmentMoments)
    AddMomentNodes(TETREC_T(SegmentMoments) sum, Real s0, Real s1, Real end, Real s, Real g) {
  return AddMomentNode(AddMomentNode(sum, s0, s1, end * s, end * g), s0, s1, end * (Real(1.0) - s),
                       end * g);
}

// Moments of a thick segment: 16 nodes over the part of it where tau(s) < 22 (beyond it 3e-10
// is left); relative error 2e-6. The recurrence of the first moment from M cancels: not used.
TETREC_FN TETREC_T(SegmentMoments) ThickSegmentMoments(Real s0, Real s1) {
  // tau(end) = 22; where the density falls so fast that 22 is never reached, the root is past 1.
  Real inside = s0 * s0 + Real(44.0) * (s1 - s0);
  Real root = Real(0.0);
  if (inside > Real(0.0)) root = sqrt(inside);
  Real end = Real(44.0) / (s0 + root);
  if (end > Real(1.0)) end = Real(1.0);
  TETREC_T(SegmentMoments) sum;
  sum.e0 = Real(0.0);
  sum.e1 = Real(0.0);
  sum.e2 = Real(0.0);
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.0052995325041750331), Real(0.013576229705877048));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.027712488463383700), Real(0.031126761969323946));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.067184398806084120), Real(0.047579255841246393));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.12229779582249850), Real(0.062314485627766936));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.19106187779867811), Real(0.074797994408288366));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.27099161117138632), Real(0.084578259697501271));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.35919822461037054), Real(0.091301707522461792));
  sum = AddMomentNodes(sum, s0, s1, end, Real(0.45249374508118127), Real(0.094725305227534248));
  return sum;
}

// The weights with their derivatives, m1 = E1 + E2, m2 = E2:
//   dw0/ds0 = m1 - m2/2, dw0/ds1 = m2/2, dw1/ds0 = T/2 - m1 + m2/2, dw1/ds1 = (T - m2)/2.
TETREC_FN TETREC_T(SegmentAdjoint)
    AdjointOfMoments(TETREC_T(SegmentMoments) moments, Real s0, Real s1, Real t) {
  TETREC_T(SegmentAdjoint) result;
  result.w0 = s0 * moments.e0 + s1 * moments.e1;
  result.w1 = s0 * moments.e1 + s1 * moments.e2;
  result.dw0_ds0 = moments.e1 + Real(0.5) * moments.e2;
  result.dw0_ds1 = Real(0.5) * moments.e2;
  result.dw1_ds0 = Real(0.5) * (t - moments.e2) - moments.e1;
  result.dw1_ds1 = Real(0.5) * (t - moments.e2);
  return result;
}

TETREC_FN TETREC_T(SegmentAdjoint) IntegrateThinSegmentWithDerivatives(Real s0, Real s1) {
  TETREC_T(SegmentMoments) moments = ThinSegmentMoments(s0, s1);
  Real t = Real(1.0) - (s0 * moments.e0 + (s0 + s1) * moments.e1 + s1 * moments.e2);
  return AdjointOfMoments(moments, s0, s1, t);
}

TETREC_FN TETREC_T(SegmentAdjoint) IntegrateThickSegmentWithDerivatives(Real s0, Real s1) {
  TETREC_T(SegmentMoments) moments = ThickSegmentMoments(s0, s1);
  return AdjointOfMoments(moments, s0, s1, exp(-(Real(0.5) * (s0 + s1))));
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentAdjoint) IntegrateSegmentWithDerivatives(Real s0, Real s1) {
  if (IsThinSegment(s0, s1)) return IntegrateThinSegmentWithDerivatives(s0, s1);
  return IntegrateThickSegmentWithDerivatives(s0, s1);
}

TETREC_END

#endif  // TETREC_SEGMENT_GLSL_H_
