// What a view should show, made from a stored image.
#pragma once

#include "image/image.h"
#include "render/training_renderer.h"

namespace tetrec {

// RGB, or RGBA with straight alpha, which is premultiplied; or with alpha that marks which pixels
// count (Scene::has_masks): the others become kNotJudgedTarget.
TargetImage TargetOf(const Image& image, bool has_masks);

}  // namespace tetrec
