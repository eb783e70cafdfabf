// How close a rendered image is to the true one, beyond PSNR (image/psnr.h).
#pragma once

#include "image/image.h"

#include <optional>

namespace tetrec {

// The protocol and the meaning of masks are those of image/psnr.h. Each function throws DataError
// if the sizes differ or an image is empty.

// Mean structural similarity over pixels and channels (Wang, Bovik, Sheikh, Simoncelli 2004):
// Gaussian window 11 x 11 with sigma 1.5, K1 = 0.01, K2 = 0.03, range 1. Pixels outside the image
// count as 0 (zero padding, as in 3D Gaussian splatting), so every pixel has a value.
double Ssim(const Image& render, const Image& truth);
// The mean over the pixels that the mask selects, with the others painted over with the truth;
// nothing if there are none.
std::optional<double> MaskedSsim(const Image& render, const Image& truth, const Image& mask);
// `image` with the pixels of `other` wherever the mask selects none.
Image PaintedOver(const Image& image, const Image& other, const Image& mask);

// The standard deviation of the brightness, the mean of the channels, over all pixels or those
// that the mask selects [8-bit levels]; 0 for an image of one colour.
double Contrast(const Image& rgb, const Image* mask = nullptr);

// Mean absolute difference of the three channels times kErrorMapGain, clipped at 1, as colours from
// black over purple and orange to pale yellow (inferno: even steps, safe for the colour-blind).
constexpr double kErrorMapGain = 4;
Image ErrorMap(const Image& render, const Image& truth);
// The scale of ErrorMap from 0 on the left to 1 / kErrorMapGain on the right.
Image ErrorMapColorBar(int width, int height);

}  // namespace tetrec
