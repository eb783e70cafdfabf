// The pinhole camera that replaces a distorting lens.
#pragma once

#include "geometry/camera.h"
#include "geometry/lens.h"

namespace tetrec {

// The pinhole camera whose image the photo fills completely (no blank pixels). Its longer side is
// at most max_size [px], and it never has more pixels than the photo. A fisheye is cut at 60
// degrees to each side, since a plane shows what is beyond only as a stretched border. Its model
// may therefore fold over outside that view; if it does so between the sides and the corners of
// that view, the corners end at 60 degrees. Throws DataError.
Camera UndistortedCamera(const Lens& lens, int max_size);
// True if that cuts the photo.
bool IsTooWideForPlane(const Lens& lens);

}  // namespace tetrec
