// Lens distortion of COLMAP's camera models, and pictures resampled to a pinhole camera: once, from
// the photo straight to the working size, so that nothing is blurred twice or compressed again.
#pragma once

#include "core/error.h"
#include "geometry/camera.h"
#include "scene/colmap_model.h"
#include "scene/image.h"

#include <filesystem>
#include <string>

namespace tetrec {

// The camera of a copy of its picture with another size. Models with one focal length become their
// like with two, since rounded sides scale differently.
ColmapCamera ScaledLens(const ColmapCamera& camera, int width, int height);

// Pixel of a direction (x, y, 1) of the camera frame. Throws DataError for a model that is none of
// ColmapLens (and so do all below).
glm::dvec2 DistortedImageFromCam(const ColmapCamera& camera, const glm::dvec2& direction);
// Its inverse, by Newton's iteration. Throws DataError where it does not converge (a lens model
// that folds over inside the picture) and where the pixel looks sideways or behind.
glm::dvec2 CamFromDistortedImage(const ColmapCamera& camera, const glm::dvec2& pixel);

// The pinhole camera whose picture is filled by the photo everywhere (no blank pixels), with the
// longer side at most max_size [px] and never more pixels than the photo has. Of fisheye lenses
// nothing beyond 60 degrees to each side is kept: a plane shows that only as a stretched border. So
// their model may fold over beyond; where it does so between there and the corners of those 60
// degrees, the corners end at 60 degrees. Throws DataError.
Camera UndistortedCamera(const ColmapCamera& camera, int max_size);
// True where that cuts the photo.
bool IsTooWideForPlane(const ColmapCamera& camera);

// The photo as the pinhole camera sees it: area mean over each target pixel, by bilinear samples at
// least as dense as the photo's pixels. Alpha is premultiplied while filtering; where it is 0 all
// channels become 0. The photo must have the size that `from` says.
Image Undistort(const Image& photo, const ColmapCamera& from, const Camera& to);

// "PICTURE (lens OPENCV): COMPLAINT; ADVICE"
[[noreturn]] void FailOnLens(const std::filesystem::path& picture, const ColmapCamera& camera,
                             const std::string& complaint, const std::string& advice);

// Calls `work`, which is one of the above; a DataError of its gets the picture and its lens in
// front and the advice behind.
template <class Work>
void NamingLens(const std::filesystem::path& picture, const ColmapCamera& camera, const Work& work,
                const std::string& advice = "") {
  try {
    work();
  } catch (const DataError& error) {
    FailOnLens(picture, camera, error.what(), advice);
  }
}

}  // namespace tetrec
