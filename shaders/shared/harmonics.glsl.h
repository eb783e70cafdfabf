// Real spherical harmonics of degrees 1 to 3: the basis of view-dependent colour.
//
// Y_lm(d) are the Cartesian polynomials of the usual real, orthonormal basis (Sloan 2008, "Stupid
// spherical harmonics tricks", appendix A2) without the Condon-Shortley phase. Function number k =
// l^2 + l + m; number 0 is constant, and the colour itself takes its place:
//   colour(d) = colour + sum_k c_k Y_k(d), with d the unit vector from the camera to the vertex.
// No |Y_k| exceeds 1.
#ifndef TETREC_HARMONICS_GLSL_H_
#define TETREC_HARMONICS_GLSL_H_

#ifdef __cplusplus
#include "shared/glsl_subset.h"
#else
#include "glsl_subset.h"
#endif

#define kMostHarmonicDegree 3
#define kMostHarmonics 15  // functions of degrees 1 to kMostHarmonicDegree

TETREC_BEGIN

// Y_k at the unit vector (x, y, z), 1 <= k <= kMostHarmonics.
TETREC_FN Real Harmonic(int k, Real x, Real y, Real z) {
  if (k == 1) return Real(0.4886025119029199) * y;
  if (k == 2) return Real(0.4886025119029199) * z;
  if (k == 3) return Real(0.4886025119029199) * x;
  if (k == 4) return Real(1.0925484305920792) * x * y;
  if (k == 5) return Real(1.0925484305920792) * y * z;
  if (k == 6) return Real(0.31539156525252005) * (Real(3.0) * z * z - Real(1.0));
  if (k == 7) return Real(1.0925484305920792) * x * z;
  if (k == 8) return Real(0.5462742152960396) * (x * x - y * y);
  if (k == 9) return Real(0.5900435899266435) * y * (Real(3.0) * x * x - y * y);
  if (k == 10) return Real(2.890611442640554) * x * y * z;
  if (k == 11) return Real(0.4570457994644658) * y * (Real(5.0) * z * z - Real(1.0));
  if (k == 12) return Real(0.3731763325901154) * z * (Real(5.0) * z * z - Real(3.0));
  if (k == 13) return Real(0.4570457994644658) * x * (Real(5.0) * z * z - Real(1.0));
  if (k == 14) return Real(1.445305721320277) * z * (x * x - y * y);
  return Real(0.5900435899266435) * x * (x * x - Real(3.0) * y * y);
}

TETREC_END

#endif  // TETREC_HARMONICS_GLSL_H_
