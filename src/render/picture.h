// From rendered colour and transmittance to pictures.
#pragma once

#include "render/renderer.h"
#include "scene/image.h"
#include "scene/scene.h"

namespace tetrec {

// Display sRGB. Photos have their far shell for a background; black stands behind what it lets
// through.
glm::vec3 BackgroundColor(Background background);

// Composited over the background, clamped to [0, 1], rounded to 8 bits. RGB.
Image ToPicture(const RenderedImage& rendered, Background background);

// A ground-truth picture (RGB, or RGBA with straight alpha) over the same background. RGB.
Image OverBackground(const Image& image, Background background);

}  // namespace tetrec
