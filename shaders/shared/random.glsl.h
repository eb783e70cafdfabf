// Random numbers for the jitter of rays: a hash, so that kernels and C++ draw the same numbers.
#ifndef TETREC_RANDOM_GLSL_H_
#define TETREC_RANDOM_GLSL_H_

#ifdef __cplusplus
#include <cstdint>
namespace tetrec::gpu_types {
using uint = uint32_t;
#define TETREC_INLINE inline
#else
#define TETREC_INLINE
#endif

// PCG hash (Jarzynski and Olano 2020, "Hash functions for GPU rendering").
TETREC_INLINE uint Hash(uint x) {
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}

TETREC_INLINE float UnitFloat(uint x) { return float(x >> 8) * float(1.0 / 16777216.0); }

#ifdef __cplusplus
}  // namespace tetrec::gpu_types
#endif

#endif  // TETREC_RANDOM_GLSL_H_
