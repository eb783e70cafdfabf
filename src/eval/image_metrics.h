// How close a rendered picture is to the true one.
#pragma once

#include "scene/image.h"

#include <optional>

namespace tetrec {

// Protocol of every number here: RGB only, 8-bit pictures of the same size, values as fractions of
// 255 (so the range is 1). Each function throws DataError where sizes differ or a picture is empty.

// Mean of the squared differences over all pixels and the three channels.
double MeanSquaredError(const Image& render, const Image& truth);

// The same over the pixels whose mask (first channel) is at least 128; nothing where there are
// none.
std::optional<double> MaskedMeanSquaredError(const Image& render, const Image& truth,
                                             const Image& mask);

// -10 log10(mse) [dB]; +infinity for equal pictures (JSON: null, as it knows no infinity).
double PsnrFromMse(double mse);

// Mean structural similarity over pixels and channels (Wang, Bovik, Sheikh, Simoncelli 2004):
// Gaussian window 11 x 11 with sigma 1.5, K1 = 0.01, K2 = 0.03, range 1. Pixels outside the picture
// count as 0 (zero padding, as 3D Gaussian splatting has it), so every pixel has a value.
double Ssim(const Image& render, const Image& truth);
// The mean over the pixels whose mask is at least 128 alone, the others painted over with the
// truth; nothing where there are none.
std::optional<double> MaskedSsim(const Image& render, const Image& truth, const Image& mask);
// `image` with `other` wherever the mask is below 128.
Image PaintedOver(const Image& image, const Image& other, const Image& mask);

// Mean absolute difference of the three channels times kErrorMapGain, clipped at 1, as colours from
// black over purple and orange to pale yellow (inferno: even steps, safe for the colour-blind).
constexpr double kErrorMapGain = 4;
Image ErrorMap(const Image& render, const Image& truth);
// The scale of ErrorMap from 0 on the left to 1 / kErrorMapGain on the right.
Image ErrorMapColorBar(int width, int height);

}  // namespace tetrec
