// The emission-absorption integral over one segment of a ray, density and colour linear along it.
//
// A segment of true length l has end densities a0, a1; s0 = a0 l and s1 = a1 l are the inputs here.
// tau(s) = s0 s + (s1 - s0) s^2 / 2, T = e^(-(s0 + s1) / 2), M = int_0^1 e^(-tau(s)) ds. Then
//   C = c0 w0 + c1 w1,  w0 = 1 - M,  w1 = M - T,  opacity 1 - T = w0 + w1
// (integration by parts of int_0^1 tau'(s) e^(-tau(s)) ((1 - s) c0 + s c1) ds).
//
// Below kSegmentSwitch w0 and w1 are integrated by Gauss-Legendre in the positive form
// int (1 - s) tau' e^(-tau), int s tau' e^(-tau), which does not cancel; above it M is closed:
//   s1 > s0: M = sqrt(pi / 2D) [erfcx(x0) - T erfcx(x1)],  s1 < s0: M = sqrt(2 / D) [F(x0) - T F(x1)]
// with D = |s1 - s0|, x_i = s_i / sqrt(2 D), F Dawson's integral. Relative error in float: 8e-7.
#ifndef TETREC_SEGMENT_GLSL_H_
#define TETREC_SEGMENT_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

TETREC_BEGIN

#define kSegmentSwitch Real(1.5)

TETREC_STRUCT SegmentWeights {
  Real w0, w1;  // weights of the colours at entry and exit
};

// The weights and their derivatives by s0 and s1; dT/ds0 = dT/ds1 = -T / 2.
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
  // Equal densities: the fits' arguments would run to infinity; the error of the mean is of order d.
  if (size <= Real(1e-7) * largest) return (Real(1.0) - t) / (Real(0.5) * (s0 + s1));
  Real scale = Real(1.0) / sqrt(Real(2.0) * size);
  if (d > Real(0.0)) {
    return Real(1.7724538509055159) * scale * (Erfcx(s0 * scale) - t * Erfcx(s1 * scale));
  }
  return Real(2.0) * scale * (Dawson(s0 * scale) - t * Dawson(s1 * scale));
}

// One Gauss-Legendre node at s with weight g, added to the sums.
TETREC_FN TETREC_T(SegmentWeights)
    AddSegmentNode(TETREC_T(SegmentWeights) sum, Real s0, Real s1, Real s, Real g) {
  Real d = s1 - s0;
  Real e = g * (s0 + d * s) * exp(-(s * (s0 + Real(0.5) * d * s)));
  sum.w1 = sum.w1 + s * e;
  sum.w0 = sum.w0 + (Real(1.0) - s) * e;
  return sum;
}

// Gauss-Legendre nodes s and 1 - s of [0, 1] that share the weight g.
TETREC_FN TETREC_T(SegmentWeights)
    AddSegmentNodes(TETREC_T(SegmentWeights) sum, Real s0, Real s1, Real s, Real g) {
  return AddSegmentNode(AddSegmentNode(sum, s0, s1, s, g), s0, s1, Real(1.0) - s, g);
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentWeights) IntegrateSegment(Real s0, Real s1) {
  Real tau = Real(0.5) * (s0 + s1);
  TETREC_T(SegmentWeights) sum;
  sum.w0 = Real(0.0);
  sum.w1 = Real(0.0);
  if (tau < kSegmentSwitch) {
    sum = AddSegmentNodes(sum, s0, s1, Real(0.033765242898423989), Real(0.085662246189585178));
    sum = AddSegmentNodes(sum, s0, s1, Real(0.16939530676686774), Real(0.18038078652406930));
    sum = AddSegmentNodes(sum, s0, s1, Real(0.38069040695840155), Real(0.23395696728634552));
  } else {
    Real t = exp(-tau);
    Real m = SegmentMeanClosed(s0, s1, t);
    sum.w0 = Real(1.0) - m;
    sum.w1 = m - t;
  }
  return sum;
}

// Moments of e^(-tau): m1 = int s e^(-tau), m2 = int s^2 e^(-tau), and the weights.
TETREC_STRUCT SegmentMoments {
  Real w0, w1, m1, m2;
};

TETREC_FN TETREC_T(SegmentMoments)
    AddMomentNode(TETREC_T(SegmentMoments) sum, Real s0, Real s1, Real s, Real g) {
  Real d = s1 - s0;
  Real e = g * exp(-(s * (s0 + Real(0.5) * d * s)));
  Real a = e * (s0 + d * s);
  sum.w1 = sum.w1 + s * a;
  sum.w0 = sum.w0 + (Real(1.0) - s) * a;
  sum.m1 = sum.m1 + s * e;
  sum.m2 = sum.m2 + s * s * e;
  return sum;
}

// Nodes s and 1 - s of [0, 1], scaled to [0, end].
TETREC_FN TETREC_T(SegmentMoments)
    AddMomentNodes(TETREC_T(SegmentMoments) sum, Real s0, Real s1, Real end, Real s, Real g) {
  return AddMomentNode(AddMomentNode(sum, s0, s1, end * s, end * g), s0, s1,
                       end * (Real(1.0) - s), end * g);
}

// The weights of IntegrateSegment with their derivatives:
//   dw0/ds0 = m1 - m2/2, dw0/ds1 = m2/2, dw1/ds0 = T/2 - m1 + m2/2, dw1/ds1 = (T - m2)/2.
// Above the switch 16 nodes over the part of the segment where tau(s) < 22 (beyond it 3e-10
// is left); relative error 2e-6. The recurrence m1 = (1 - T - s0 M) / (s1 - s0) cancels: not used.
TETREC_FN TETREC_T(SegmentAdjoint) IntegrateSegmentWithDerivatives(Real s0, Real s1) {
  Real tau = Real(0.5) * (s0 + s1);
  Real t = exp(-tau);
  TETREC_T(SegmentMoments) sum;
  sum.w0 = Real(0.0);
  sum.w1 = Real(0.0);
  sum.m1 = Real(0.0);
  sum.m2 = Real(0.0);
  if (tau < kSegmentSwitch) {
    Real one = Real(1.0);
    sum = AddMomentNodes(sum, s0, s1, one, Real(0.033765242898423989), Real(0.085662246189585178));
    sum = AddMomentNodes(sum, s0, s1, one, Real(0.16939530676686774), Real(0.18038078652406930));
    sum = AddMomentNodes(sum, s0, s1, one, Real(0.38069040695840155), Real(0.23395696728634552));
  } else {
    // tau(end) = 22; where the density falls so fast that 22 is never reached, the root is past 1.
    Real inside = s0 * s0 + Real(44.0) * (s1 - s0);
    Real root = inside > Real(0.0) ? sqrt(inside) : Real(0.0);
    Real end = Real(44.0) / (s0 + root);
    if (end > Real(1.0)) end = Real(1.0);
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.0052995325041750331), Real(0.013576229705877048));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.027712488463383700), Real(0.031126761969323946));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.067184398806084120), Real(0.047579255841246393));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.12229779582249850), Real(0.062314485627766936));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.19106187779867811), Real(0.074797994408288366));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.27099161117138632), Real(0.084578259697501271));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.35919822461037054), Real(0.091301707522461792));
    sum = AddMomentNodes(sum, s0, s1, end, Real(0.45249374508118127), Real(0.094725305227534248));
  }
  TETREC_T(SegmentAdjoint) result;
  result.w0 = sum.w0;
  result.w1 = sum.w1;
  result.dw0_ds0 = sum.m1 - Real(0.5) * sum.m2;
  result.dw0_ds1 = Real(0.5) * sum.m2;
  result.dw1_ds0 = Real(0.5) * t - sum.m1 + Real(0.5) * sum.m2;
  result.dw1_ds1 = Real(0.5) * (t - sum.m2);
  return result;
}

TETREC_END

#endif  // TETREC_SEGMENT_GLSL_H_
