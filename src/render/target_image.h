// What a view should show, made from a stored image.
#pragma once

#include "image/image.h"
#include "render/training_renderer.h"
#include "scene/scene.h"

namespace tetrec {

// RGB, or RGBA with straight alpha, which is premultiplied; or with alpha that marks which pixels
// count (Scene::has_masks): the others become kNotJudgedTarget.
TargetImage TargetOf(const Image& image, bool has_masks);

// The same as a picture, to compare with renderings over this background. RGB. Where alpha marks
// which pixels count, these are as stored, even if their alpha is not 255; the others, which are
// not judged, are composited like opacity.
Image TruthOf(const Image& image, bool has_masks, Background background);

}  // namespace tetrec
