// A small random generator whose whole state is a seed and a stream number.
#pragma once

#include <cstdint>

namespace tetrec {

// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators").
class Random {
 public:
  explicit Random(uint64_t seed, uint64_t stream = 0)
      : state_(seed * 0x9E3779B97F4A7C15ull ^ (stream + 1) * 0xD1B54A32D192ED03ull) {
    Next();
  }
  uint64_t Next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  // In [0, 1).
  double Uniform() { return double(Next() >> 11) * 0x1.0p-53; }
  // In [0, count), count > 0.
  uint32_t Below(uint32_t count) { return uint32_t((Next() >> 32) * count >> 32); }

 private:
  uint64_t state_;
};

}  // namespace tetrec
