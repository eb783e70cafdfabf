// Sums that many rays add to: AddTo(sum, value, quanta). They are floats, added natively if the
// device can do so and by compare-and-swap on the bits otherwise; or, with TETREC_FIXED_POINT,
// 64-bit counts of quanta, whose sum does not depend on the order. `quanta` is the number of quanta
// per unit of value.
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#define Sum int64_t
// An addend beyond push.rays.largest_quanta is clamped, a NaN becomes 0, and both are counted: so
// no sum overflows.
#define AddTo(sum, value, quanta)                                                     \
  {                                                                                   \
    float addend = (value) * (quanta);                                                \
    bool fits = abs(addend) <= push.rays.largest_quanta;                              \
    TETREC_RARELY(!fits) {                                                            \
      atomicAdd(counters[kCounterClamped], 1u);                                       \
      addend = isnan(addend) ? 0.0 : sign(addend) * push.rays.largest_quanta;         \
    }                                                                                 \
    atomicAdd(sum, int64_t(roundEven(addend)));                                       \
  }
#elif defined(TETREC_FLOAT_ATOMICS)
#extension GL_EXT_shader_atomic_float : require
#define Sum float
#define AddTo(sum, value, quanta) atomicAdd(sum, value)
#else
#define Sum uint
#define AddTo(sum, value, quanta)                                                                \
  {                                                                                              \
    uint seen = sum;                                                                             \
    bool again = true;                                                                           \
    while (again) {                                                                              \
      uint before = seen;                                                                        \
      seen = atomicCompSwap(sum, before, floatBitsToUint(uintBitsToFloat(before) + (value)));    \
      again = seen != before;                                                                    \
    }                                                                                            \
  }
#endif
