// Known pixels of an image are continued into the others.
#pragma once

#include "image/image.h"

#include <cstddef>
#include <functional>

namespace tetrec {

// Gives each pixel that is not known the mean colour of the known ones around it, from finer means
// near them to coarser ones far away. `image` is RGB. Method: Gortler et al., The Lumigraph,
// 1996 (pull and push).
void ContinueColors(Image& image, const std::function<bool(size_t)>& is_known);

}  // namespace tetrec
