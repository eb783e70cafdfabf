// Lens distortion of COLMAP's camera models, and pictures resampled to a pinhole camera: once, from
// the photo straight to the working size, so that nothing is blurred twice or compressed again.
#pragma once

#include "geometry/camera.h"
#include "scene/colmap_model.h"
#include "scene/image.h"

namespace tetrec {

// True for SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV.
bool CanUndistort(const ColmapCamera& camera);

// Pixel of a direction (x, y, 1) of the camera frame.
glm::dvec2 DistortedImageFromCam(const ColmapCamera& camera, const glm::dvec2& direction);
// Its inverse, by Newton's iteration. Throws DataError where it does not converge (a lens model
// that folds over inside the picture).
glm::dvec2 CamFromDistortedImage(const ColmapCamera& camera, const glm::dvec2& pixel);

// The pinhole camera whose picture is filled by the photo everywhere (no blank pixels), with the
// longer side at most max_size [px] and never more pixels than the photo has. Throws DataError.
Camera UndistortedCamera(const ColmapCamera& camera, int max_size);

// The photo as the pinhole camera sees it: area mean over each target pixel, by bilinear samples at
// least as dense as the photo's pixels. The photo must have the size that `from` says.
Image Undistort(const Image& photo, const ColmapCamera& from, const Camera& to);

}  // namespace tetrec
