// Doubts about a lens that the photos may not determine.
#pragma once

#include "colmap/model.h"

#include <cstddef>
#include <optional>
#include <string>

namespace tetrec {

// Why the photos may not determine the lens that was found.
struct LensDoubt {
  std::string reason;
  bool is_unusable = false;  // the lens cannot be undone inside the photos
  // The share of the photos it registered that a simpler lens must register, too, to be taken.
  double least_photos = 1;
  bool has_too_few_photos = false;  // HasEnoughPhotos
};

// Where features lie only in the middle of the photos, nothing determines a lens of many parameters
// at the borders. And where the camera is always level and the photos are few, or a subject turns
// in front of it, nothing determines how wide a pixel is. A lens of many parameters that fits the
// first few photos may also be the reason why no others fit.
// `photos`: all of them; `max_size`: of the pictures without distortion (SfmOptions).
std::optional<LensDoubt> DoubtOf(const ColmapModel& model, size_t photos, int max_size);

// Whether a model with a simpler lens replaces the doubted one. If the pixels really are oblong, a
// lens with square ones registers fewer photos or points, or its error is larger: by 46 % on a
// level walk whose pixels are 0.77 times as wide as high. If they are square, it is not. A model of
// too few photos is replaced by any better one (IsBetterModel).
bool Replaces(const ColmapModel& simpler, const ColmapModel& model, const LensDoubt& doubt,
              size_t photos, int max_size);

}  // namespace tetrec
