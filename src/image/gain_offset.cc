// The gain and offset that bring one channel of an image closest to another, by least squares.
#include "image/gain_offset.h"

namespace tetrec {

// The share of the product of its diagonal below which a determinant is rounding.
constexpr double kLeastDeterminant = 1e-9;

// The normal equations, with d = gain - 1:
//   (xx + a) d + xw offset = yx - xx,  xw d + (ww + b) offset = yw - xw.
std::optional<GainOffset> FitGainOffset(const GainOffsetSums& sums, const GainOffsetPrior& prior) {
  const double a = sums.xx + prior.gain, b = sums.ww + prior.offset;
  const double determinant = a * b - sums.xw * sums.xw;
  if (!(determinant > kLeastDeterminant * a * b)) return std::nullopt;
  const double by_gain = sums.yx - sums.xx, by_offset = sums.yw - sums.xw;
  return GainOffset{1 + (b * by_gain - sums.xw * by_offset) / determinant,
                    (a * by_offset - sums.xw * by_gain) / determinant};
}

}  // namespace tetrec
