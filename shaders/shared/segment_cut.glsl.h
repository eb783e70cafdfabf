// The part of a segment in which its density is positive.
//
// Values of density may be negative; what is rendered is max(0, value), with the value linear
// inside a tet. So a surface may lie anywhere between two vertices. Of a segment whose end values
// d0 and d1 differ in sign, the part on the positive side remains, with density 0 where it was cut.
//
// Gradients with respect to the ends of the part become those of the whole segment by the same
// weights by which the part's ends interpolate the whole's: the place of the cut needs no gradient
// of its own, because density is 0 there (the boundary term of the integral's derivative is 0).
#ifndef TETREC_SEGMENT_CUT_GLSL_H_
#define TETREC_SEGMENT_CUT_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

TETREC_BEGIN

// Shares of the segment's length, 0 <= begin <= end <= 1.
TETREC_STRUCT SegmentCut { Real begin, end; };

// The share at which a value of the sign of d0 at 0 and of the other at 1 is 0. Division on a GPU
// may round past 1, and of denormals be anything.
TETREC_FN Real ZeroBetween(Real d0, Real d1) {
  Real share = d0 / (d0 - d1);
  if (!(share > Real(0.0))) return Real(0.0);
  return share < Real(1.0) ? share : Real(1.0);
}

// d0 and d1 are finite. A segment that is negative at both ends keeps nothing: begin = end.
TETREC_FN TETREC_T(SegmentCut) CutAtZero(Real d0, Real d1) {
  TETREC_T(SegmentCut) cut;
  cut.begin = Real(0.0);
  cut.end = Real(1.0);
  if (d0 < Real(0.0)) cut.begin = d1 > Real(0.0) ? ZeroBetween(d0, d1) : Real(1.0);
  if (d1 < Real(0.0)) cut.end = d0 > Real(0.0) ? ZeroBetween(d0, d1) : cut.begin;
  return cut;
}

// Density at an end whose value is d; it is 0 at a cut.
TETREC_FN Real DensityOf(Real d) { return d > Real(0.0) ? d : Real(0.0); }

TETREC_END

#endif  // TETREC_SEGMENT_CUT_GLSL_H_
