// The integral over one segment cut into n equal parts of constant density: the article's N_sub
// (algorithm 2, "Tetrahedron color accumulation").
//
// Part i has the density at its middle, so its optical depth is tau_i = (s0 + (s1 - s0) x) / n at
// x = (i + 1/2) / n, and the colours at its ends, at the fractions i / n and (i + 1) / n of the
// segment. Parts are composited front to back. As printed, each part interpolates its colours by
// the distance in metres where the fraction of the part is meant, so that short parts show only
// their entry colour; here a part has the weights of segment_mean.glsl.h. The public code also
// omits the first part in its backward pass; the derivatives here follow the product rule over
// every part. The depths add up to (s0 + s1) / 2: the opacity is exact for every n, and the error
// of the weights is O(1 / n^2).
//
// With T_i = e^-(tau_0 + ... + tau_(i-1)) and u_i, v_i the weights of part i
//   w0 = sum_i T_i (u_i (n - i) + v_i (n - i - 1)) / n,  w1 = sum_i T_i (u_i i + v_i (i + 1)) / n,
// sums of positive terms. T_i depends on s0 and s1 through the exact depth before part i, at x = i
// / n:
//   -dlog T_i / ds0 = x - x^2 / 2,  -dlog T_i / ds1 = x^2 / 2.
// Relative error in float: 1e-6, plus 1e-7 n from n roundings of T_i.
#ifndef TETREC_SEGMENT_SPLIT_GLSL_H_
#define TETREC_SEGMENT_SPLIT_GLSL_H_

#include "segment_mean.glsl.h"

TETREC_BEGIN

// Part i: its own quantities, and its share of w0 and w1 and of their derivatives with respect to
// its depth if nothing is before it.
TETREC_STRUCT SplitPart {
  Real begin, middle;  // fractions of the segment
  Real t, w0, w1, dw0, dw1;
};

// size = 1 / n.
TETREC_FN TETREC_T(SplitPart) IntegrateSplitPart(int i, Real size, Real s0, Real s1) {
  TETREC_T(SplitPart) part;
  part.begin = size * Real(i);
  part.middle = size * (Real(i) + Real(0.5));
  Real end = size * Real(i + 1);
  TETREC_T(ConstantSegment)
  own = IntegrateConstantSegment(size * (s0 * (Real(1.0) - part.middle) + s1 * part.middle));
  part.t = own.t;
  part.w0 = own.w0 * (Real(1.0) - part.begin) + own.w1 * (Real(1.0) - end);
  part.w1 = own.w0 * part.begin + own.w1 * end;
  part.dw0 = own.dw0 * (Real(1.0) - part.begin) + own.dw1 * (Real(1.0) - end);
  part.dw1 = own.dw0 * part.begin + own.dw1 * end;
  return part;
}

// n >= 1; s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentWeights) IntegrateSplitSegment(int n, Real s0, Real s1) {
  Real size = Real(1.0) / Real(n);
  Real before = Real(1.0);  // T_i
  TETREC_T(SegmentWeights) sum;
  sum.w0 = sum.w1 = Real(0.0);
  int i = 0;
  while (i < n) {
    TETREC_T(SplitPart) part = IntegrateSplitPart(i, size, s0, s1);
    sum.w0 = sum.w0 + before * part.w0;
    sum.w1 = sum.w1 + before * part.w1;
    before = before * part.t;
    i += 1;
  }
  return sum;
}

// n >= 1; s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentAdjoint) IntegrateSplitSegmentWithDerivatives(int n, Real s0, Real s1) {
  Real size = Real(1.0) / Real(n);
  Real before = Real(1.0);
  TETREC_T(SegmentAdjoint) sum;
  sum.w0 = sum.w1 = Real(0.0);
  sum.dw0_ds0 = sum.dw0_ds1 = sum.dw1_ds0 = sum.dw1_ds1 = Real(0.0);
  int i = 0;
  while (i < n) {
    TETREC_T(SplitPart) part = IntegrateSplitPart(i, size, s0, s1);
    Real own_by_s1 = size * part.middle, own_by_s0 = size - own_by_s1;
    Real before_by_s1 = Real(0.5) * part.begin * part.begin;
    Real before_by_s0 = part.begin - before_by_s1;
    sum.w0 = sum.w0 + before * part.w0;
    sum.w1 = sum.w1 + before * part.w1;
    sum.dw0_ds0 = sum.dw0_ds0 + before * (own_by_s0 * part.dw0 - before_by_s0 * part.w0);
    sum.dw0_ds1 = sum.dw0_ds1 + before * (own_by_s1 * part.dw0 - before_by_s1 * part.w0);
    sum.dw1_ds0 = sum.dw1_ds0 + before * (own_by_s0 * part.dw1 - before_by_s0 * part.w1);
    sum.dw1_ds1 = sum.dw1_ds1 + before * (own_by_s1 * part.dw1 - before_by_s1 * part.w1);
    before = before * part.t;
    i += 1;
  }
  return sum;
}

TETREC_END

#endif  // TETREC_SEGMENT_SPLIT_GLSL_H_
