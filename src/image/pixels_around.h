// The pixels around a position of an image.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <array>

namespace tetrec {

struct WeightedPixel {
  int x, y;
  double weight;  // of bilinear interpolation; may be 0
};

// The weights add up to 1. `position` is measured from the image's corner [px]; beyond the centres
// of the outer pixels it counts as on their line. A pixel of weight 0 may be outside of the image.
inline std::array<WeightedPixel, 4> PixelsAround(int width, int height,
                                                 const glm::dvec2& position) {
  const double left = std::clamp(position.x - 0.5, 0.0, double(width - 1)),
               top = std::clamp(position.y - 0.5, 0.0, double(height - 1));
  const int x = int(left), y = int(top);
  const double u = left - x, v = top - y;
  return {{{x, y, (1 - u) * (1 - v)},
           {x + 1, y, u * (1 - v)},
           {x, y + 1, (1 - u) * v},
           {x + 1, y + 1, u * v}}};
}

}  // namespace tetrec
