// Another size for the eye.
#pragma once

#include "image/image.h"

namespace tetrec {

// The area mean (ResizeByArea) along an axis that becomes shorter, and linear interpolation between
// the pixels' centres along one that becomes longer, so that enlarged pixels have no hard borders.
// Alpha is premultiplied while filtering; if it is 0, all channels become 0.
Image ResizeSmoothly(const Image& image, int width, int height);

}  // namespace tetrec
