// Random numbers that are the same with every standard library, whose distributions are not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <utility>

namespace tetrec {

// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators"). Its whole
// state is one number made of a seed and a stream, so each iteration can draw from its own stream
// and a resumed run draws what an uninterrupted one would have.
class SplitMix64 {
 public:
  explicit SplitMix64(uint64_t seed, uint64_t stream = 0)
      : state_(seed * 0x9E3779B97F4A7C15ull ^ (stream + 1) * 0xD1B54A32D192ED03ull) {
    (*this)();
  }
  uint64_t operator()() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

 private:
  uint64_t state_;
};

// Draws from an engine of 64 random bits per call.
template <class Engine>
class RandomNumbers {
 public:
  template <class... Seed>
  explicit RandomNumbers(uint64_t seed, Seed... stream) : engine_(seed, stream...) {}

  uint64_t Next() { return engine_(); }
  // In [0, 1).
  double Uniform() { return double(Next() >> 11) * 0x1.0p-53; }
  // In [0, count), count > 0.
  uint32_t Below(uint32_t count) { return uint32_t((Next() >> 32) * count >> 32); }

 private:
  Engine engine_;
};

// Moves `count` of the items, drawn at random, none twice, to the front, in the order of their
// drawing (Fisher and Yates).
template <class Item, class Engine>
void DrawInFront(std::span<Item> items, size_t count, RandomNumbers<Engine>& random) {
  for (size_t i = 0; i < count; ++i) {
    std::swap(items[i], items[i + random.Below(uint32_t(items.size() - i))]);
  }
}

// The optimiser's generator: Random(seed, stream).
using Random = RandomNumbers<SplitMix64>;
// The generator of everything drawn once per run from one seed: MersenneRandom(seed).
using MersenneRandom = RandomNumbers<std::mt19937_64>;

}  // namespace tetrec
