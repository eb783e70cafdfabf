// The gain and offset that bring one channel of an image closest to another, by least squares.
#pragma once

#include <optional>

namespace tetrec {

// wanted = gain x + offset [display sRGB in 0 .. 1].
struct GainOffset {
  double gain = 1, offset = 0;
};

// Sums over samples of y = gain x + offset w. w is 1 for opaque pixels; where x is premultiplied by
// an opacity, w is that opacity.
struct GainOffsetSums {
  double ww = 0, xw = 0, xx = 0, yw = 0, yx = 0;

  void Add(double x, double w, double y) {
    ww += w * w;
    xw += x * w;
    xx += x * x;
    yw += y * w;
    yx += y * x;
  }
  GainOffsetSums& operator+=(const GainOffsetSums& other) {
    ww += other.ww;
    xw += other.xw;
    xx += other.xx;
    yw += other.yw;
    yx += other.yx;
    return *this;
  }
  bool operator==(const GainOffsetSums&) const = default;
};

// Weights of a pull towards gain 1 and offset 0, in samples of x = 1 and of w = 1.
struct GainOffsetPrior {
  double gain = 0, offset = 0;
};

// Minimises sum (gain x + offset w - y)^2 + prior.gain (gain - 1)^2 + prior.offset offset^2.
// Nothing if samples and prior do not determine both numbers, as where all x are equal.
std::optional<GainOffset> FitGainOffset(const GainOffsetSums& sums,
                                        const GainOffsetPrior& prior = {});

}  // namespace tetrec
