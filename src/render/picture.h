// Images made from rendered colour and transmittance.
#pragma once

#include "image/image.h"
#include "render/renderer.h"
#include "scene/scene.h"

namespace tetrec {

// Display sRGB. For photos the far shell is the background, and what it lets through is black.
glm::vec3 BackgroundColor(Background background);

// Composited over the background, clamped to [0, 1], rounded to 8 bits. RGB.
Image ToPicture(const RenderedImage& rendered, Background background);

// The alpha of a ground-truth image as a grey RGB image, which selects the subject, or the pixels
// that count (Scene::has_masks).
Image MaskOf(const Image& rgba);

}  // namespace tetrec
