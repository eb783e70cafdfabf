// The three forms of the segment integral behind one choice. Kernels pass specialization constants
// (shaders/integral.glsl), so that the driver folds the choice and unrolls the parts.
//
// Kernels may move thick segments, which only the exact form has, out of their hot loop.
#ifndef TETREC_INTEGRAL_GLSL_H_
#define TETREC_INTEGRAL_GLSL_H_

#include "segment_split.glsl.h"

#define kIntegralExact 0
#define kIntegralMean 1
#define kIntegralSplit 2
// Specialization constants of the kernels.
#define kConstantIntegral 0
#define kConstantSplits 1

TETREC_BEGIN

TETREC_FN bool IsThickSegment(int integral, Real s0, Real s1) {
  return integral == kIntegralExact && !IsThinSegment(s0, s1);
}

// Not for thick segments. `splits` matters for kIntegralSplit only.
TETREC_FN TETREC_T(SegmentWeights)
    IntegrateUnlessThick(int integral, int splits, Real s0, Real s1) {
  if (integral == kIntegralMean) return IntegrateMeanSegment(s0, s1);
  if (integral == kIntegralSplit) return IntegrateSplitSegment(splits, s0, s1);
  return IntegrateThinSegment(s0, s1);
}

TETREC_FN TETREC_T(SegmentAdjoint)
    IntegrateUnlessThickWithDerivatives(int integral, int splits, Real s0, Real s1) {
  if (integral == kIntegralMean) return IntegrateMeanSegmentWithDerivatives(s0, s1);
  if (integral == kIntegralSplit) return IntegrateSplitSegmentWithDerivatives(splits, s0, s1);
  return IntegrateThinSegmentWithDerivatives(s0, s1);
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentWeights) IntegrateSegmentBy(int integral, int splits, Real s0, Real s1) {
  if (IsThickSegment(integral, s0, s1)) return IntegrateThickSegment(s0, s1);
  return IntegrateUnlessThick(integral, splits, s0, s1);
}

// s0, s1 >= 0, finite.
TETREC_FN TETREC_T(SegmentAdjoint)
    IntegrateSegmentByWithDerivatives(int integral, int splits, Real s0, Real s1) {
  if (IsThickSegment(integral, s0, s1)) return IntegrateThickSegmentWithDerivatives(s0, s1);
  return IntegrateUnlessThickWithDerivatives(integral, splits, s0, s1);
}

TETREC_END

#endif  // TETREC_INTEGRAL_GLSL_H_
