// How close a rendered image is to the true one apart from exposure and white balance.
#pragma once

#include "image/gain_offset.h"
#include "image/image.h"

#include <array>
#include <optional>

namespace tetrec {

// By channel.
using ColorCorrection = std::array<GainOffset, 3>;

// Fits the colours of `render` to those of `truth` where `mask` (may be null) selects the pixel. A
// channel that is constant there gets the offset between the means and gain 1. Throws DataError if
// the sizes differ.
ColorCorrection FitColors(const Image& render, const Image& truth, const Image* mask);
// The corrected image, rounded to 8 bits.
Image WithColors(const Image& image, const ColorCorrection& correction);

// Errors of the right half of a view: as it is rendered, and with the correction that was fitted on
// the left half. The two halves share no pixel, so the correction has seen nothing of what it is
// judged by.
struct HalfScores {
  double raw_mse = 0, corrected_mse = 0;
};
// Nothing if one of the halves has no pixel that the mask selects. Protocol: image/psnr.h.
std::optional<HalfScores> ScoreHalves(const Image& render, const Image& truth, const Image* mask);

}  // namespace tetrec
