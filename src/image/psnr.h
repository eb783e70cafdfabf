// Squared error and PSNR between a rendered image and the true one.
#pragma once

#include "image/image.h"

#include <optional>

namespace tetrec {

// Protocol of every number here: RGB only, 8-bit images of the same size, values as fractions of
// 255 (so the range is 1).

// Throws DataError unless `render` and `other` have the same size; `other_is` names it: "mask".
void CheckSameSize(const Image& render, const Image& other, const char* other_is);

// A mask selects the pixels whose first channel is at least this.
inline constexpr uint8_t kSelectedByMask = 128;

// Mean of the squared differences over all pixels and the three channels.
double MeanSquaredError(const Image& render, const Image& truth);
// The same over the pixels that the mask selects; nothing if there are none.
std::optional<double> MaskedMeanSquaredError(const Image& render, const Image& truth,
                                             const Image& mask);

// -10 log10(mse) [dB]; +infinity for equal images, which metrics.json writes as null.
double PsnrFromMse(double mse);
// The same, but at most 100 dB, for means that must stay finite. An 8-bit image of 10,000 pixels
// that differs from the truth at all has at most 93 dB.
inline constexpr double kPsnrCap_db = 100;
double CappedPsnrFromMse(double mse);

}  // namespace tetrec
