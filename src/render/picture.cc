// Images made from rendered colour and transmittance.
#include "render/picture.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

glm::vec3 BackgroundColor(Background background) {
  return glm::vec3(background == Background::kWhite ? 1.0f : 0.0f);
}

Image ToPicture(const RenderedImage& rendered, Background background) {
  Image image{rendered.width, rendered.height, 3, {}};
  image.pixels.reserve(rendered.color_srgb.size() * 3);
  for (size_t i = 0; i < rendered.color_srgb.size(); ++i) {
    const glm::vec3 color =
        rendered.color_srgb[i] + rendered.transmittance[i] * BackgroundColor(background);
    for (int c = 0; c < 3; ++c) {
      image.pixels.push_back(uint8_t(std::lround(255.0f * std::clamp(color[c], 0.0f, 1.0f))));
    }
  }
  return image;
}

Image MaskOf(const Image& rgba) {
  Image mask{rgba.width, rgba.height, 3, {}};
  for (size_t i = 0; i < rgba.pixels.size(); i += 4) {
    mask.pixels.insert(mask.pixels.end(), 3, rgba.pixels[i + 3]);
  }
  return mask;
}

}  // namespace tetrec
