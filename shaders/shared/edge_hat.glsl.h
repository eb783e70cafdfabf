// The hat function of a vertex that would halve an edge: 1 in the edge's middle, linear in both
// halves of each tet at the edge, 0 at the vertices that there are.
#ifndef TETREC_EDGE_HAT_GLSL_H_
#define TETREC_EDGE_HAT_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif
#include "segment_cut.glsl.h"

TETREC_BEGIN

// At a point of a tet: twice the lesser barycentric weight of the edge's ends.
TETREC_FN Real HatAt(Real a, Real b) { return Real(2.0) * (a < b ? a : b); }

// The mean over a segment at whose ends the weights of the edge's ends are a0, b0 and a1, b1. The
// hat has a kink where both weights are equal.
TETREC_FN Real MeanHat(Real a0, Real b0, Real a1, Real b1) {
  Real d0 = a0 - b0, d1 = a1 - b1;
  Real at_begin = HatAt(a0, b0), at_end = HatAt(a1, b1);
  if (!(d0 * d1 < Real(0.0))) return Real(0.5) * (at_begin + at_end);
  Real share = ZeroBetween(d0, d1);
  Real at_kink = Real(2.0) * (a0 + share * (a1 - a0));
  return Real(0.5) * (at_kink + share * at_begin + (Real(1.0) - share) * at_end);
}

TETREC_END

#endif  // TETREC_EDGE_HAT_GLSL_H_
