// Atomic addition of floats: native where the device has it, else compare and swap on the bits.
#ifdef TETREC_FLOAT_ATOMICS
#extension GL_EXT_shader_atomic_float : require
#define AtomicFloat float
#define AddFloat(target, value) atomicAdd(target, value)
#else
#define AtomicFloat uint
#define AddFloat(target, value)                                             \
  {                                                                         \
    uint seen = target;                                                     \
    bool again = true;                                                      \
    while (again) {                                                         \
      uint before = seen;                                                   \
      seen = atomicCompSwap(target, before, floatBitsToUint(uintBitsToFloat(before) + (value))); \
      again = seen != before;                                               \
    }                                                                       \
  }
#endif
