// The subset of language that GLSL and C++ share, so that a formula is written once.
//
// Rules: scalars are Real (float in GLSL; float, double or ceres::Jet in C++), literals Real(0.5),
// no swizzles, no inout, results are returned as structs. A templated struct S is named
// TETREC_T(S).
#ifndef TETREC_GLSL_SUBSET_H_
#define TETREC_GLSL_SUBSET_H_

#ifdef __cplusplus
#include <cmath>
#include <cstdint>
namespace tetrec {
// For built-in types; those of ceres::Jet are found by argument-dependent lookup.
using std::cosh;
using std::exp;
using std::log1p;
using std::sinh;
using std::sqrt;
}  // namespace tetrec
#define TETREC_BEGIN namespace tetrec {
#define TETREC_END }
#define TETREC_STRUCT   \
  template <class Real> \
  struct
#define TETREC_FN       \
  template <class Real> \
  inline
#define TETREC_T(type) type<Real>
#define TETREC_RARELY(condition) if (condition)
#else
#define Real float
#define TETREC_BEGIN
#define TETREC_END
#define TETREC_STRUCT struct
#define TETREC_FN
#define TETREC_T(type) type
// A branch that is really skipped: lavapipe runs both sides of an `if` under masks, but skips a
// loop that no lane enters. The kernel defines TETREC_NEVER, a condition that is false whenever a
// thread has work, which the compiler cannot know (it would turn the loop back into an `if`).
#define TETREC_RARELY(condition) for (bool rarely_ = (condition); rarely_; rarely_ = TETREC_NEVER)
#endif

#endif  // TETREC_GLSL_SUBSET_H_
