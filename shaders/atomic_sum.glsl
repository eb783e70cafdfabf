// Sums that many rays add to: AddTo(sum, value, quanta). Floats, added natively where the device can,
// else by compare and swap on the bits; or, with TETREC_FIXED_POINT, 64-bit counts of quanta, whose
// sum is the same in any order. `quanta` is the number of them to one unit of value.
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#define Sum int64_t
// An addend beyond push.largest_quanta, or none (NaN), is clamped and counted: so no sum runs over.
#define AddTo(sum, value, quanta)                                                     \
  {                                                                                   \
    float addend = (value) * (quanta);                                                \
    bool fits = abs(addend) <= push.largest_quanta;                                   \
    TETREC_RARELY(!fits) {                                                            \
      atomicAdd(counters[kCounterClamped], 1u);                                       \
      addend = isnan(addend) ? 0.0 : sign(addend) * push.largest_quanta;              \
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
