// Display sRGB and linear RGB (IEC 61966-2-1), [0, 1] each.
#pragma once

#include <glm/glm.hpp>

#include <cmath>

namespace tetrec {

inline double LinearFromSrgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
inline double SrgbFromLinear(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

inline glm::dvec3 LinearFromSrgb(const glm::dvec3& color) {
  return {LinearFromSrgb(color.r), LinearFromSrgb(color.g), LinearFromSrgb(color.b)};
}
inline glm::dvec3 SrgbFromLinear(const glm::dvec3& color) {
  return {SrgbFromLinear(color.r), SrgbFromLinear(color.g), SrgbFromLinear(color.b)};
}

}  // namespace tetrec
