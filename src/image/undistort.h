// Images resampled to a pinhole camera: once, from the photo straight to the working size, so that
// nothing is blurred twice or compressed again.
#pragma once

#include "core/error.h"
#include "geometry/camera.h"
#include "geometry/lens.h"
#include "image/image.h"

#include <filesystem>
#include <string>

namespace tetrec {

// The photo as the pinhole camera sees it: the mean over the area of each target pixel, by bilinear
// samples at least as dense as the photo's pixels. Alpha is premultiplied while filtering; if it is
// 0, all channels become 0. The photo must have the lens' size. Throws DataError if the lens has no
// pixel for a direction.
Image Undistort(const Image& photo, const Lens& from, const Camera& to);

// Throws DataError("PHOTO (lens OPENCV): COMPLAINT; ADVICE").
[[noreturn]] void FailOnLens(const std::filesystem::path& photo, const Lens& lens,
                             const std::string& complaint, const std::string& advice);

// Calls `work`, which uses the lens; prefixes its DataError with the photo and the lens, and
// appends the advice.
template <class Work>
void NamingLens(const std::filesystem::path& photo, const Lens& lens, const Work& work,
                const std::string& advice = "") {
  try {
    work();
  } catch (const DataError& error) {
    FailOnLens(photo, lens, error.what(), advice);
  }
}

}  // namespace tetrec
