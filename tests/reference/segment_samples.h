// Random segments (s0, s1) over the whole range that rays encounter, hard cases included.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace reference {

struct SegmentSample {
  float s0, s1;  // optical depth per unit fraction at start and end
};

// Zero, 1e-8 to 1e4, nearly equal ends (relative difference 1e-9 to 0.1), one end zero. A quarter
// of the samples is around the switch between the product's two formulas (mean depth 0.3 to 30).
inline std::vector<SegmentSample> DrawSegments(int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto power = [&](double low, double high) {
    return std::pow(10.0, low + (high - low) * unit(random));
  };
  std::vector<SegmentSample> samples;
  for (int i = 0; i < count; ++i) {
    double s0 = unit(random) < 0.1 ? 0.0 : power(-8, 4);
    double s1 = unit(random) < 0.1 ? 0.0 : power(-8, 4);
    switch (i % 4) {
      case 0:
        s1 = s0 * (1 + (unit(random) < 0.5 ? -1 : 1) * power(-9, -1));
        break;
      case 1: {
        const double tau = power(-0.5, 1.5);
        const double share = std::clamp(1.4 * unit(random) - 0.2, 0.0, 1.0);
        s0 = 2 * tau * share;
        s1 = 2 * tau * (1 - share);
        break;
      }
      default:
        break;
    }
    samples.push_back({static_cast<float>(s0), static_cast<float>(s1)});
  }
  return samples;
}

}  // namespace reference
