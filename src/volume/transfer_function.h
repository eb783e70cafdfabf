// Transfer functions: opacity and colour of a volume's samples, piecewise linear in the normalised
// sample and constant before the first and after the last position.
//
// Tetrec's format is {"opacity": [[x, opacity]...], "colour": [[x, r, g, b]...]}, all in [0, 1]
// with x rising strictly; colours are given in sRGB and interpolated in linear RGB. ParaView's is
// an array of one colour map with "ColorSpace": "RGB", "RGBPoints": [x, r, g, b...] and "Points":
// [x, opacity, midpoint, sharpness...] with midpoint 0.5 and sharpness 0; positions are values of
// the samples or, if the map spans exactly 0 to 1, normalised; colours are interpolated as given,
// in sRGB.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <vector>

namespace tetrec {

// The space in which colours are linear between two positions.
enum class ColorInterpolation { kLinearRgb, kSrgb };

struct TransferFunction {
  struct OpacityPoint {
    double x = 0, opacity = 0;
  };
  struct ColorPoint {
    double x = 0;
    glm::dvec3 color_srgb{0.0};
  };
  std::vector<OpacityPoint> opacity;  // at least one; x rises strictly within [0, 1]
  std::vector<ColorPoint> color;      // likewise
  ColorInterpolation interpolation = ColorInterpolation::kLinearRgb;
  // The file's positions are values of the samples, which do not depend on the values that become 0
  // and 1.
  bool given_in_values = false;

  double OpacityAt(double x) const;
  glm::dvec3 SrgbAt(double x) const;  // display sRGB
  // The stretches with opacity above 0: begin and end of each, in rising order.
  std::vector<glm::dvec2> OpaqueStretches() const;
};

// Reads either format, recognised by the outermost bracket. `values_at_0_and_1` are the values of
// normalised samples of 0 and 1. Throws DataError naming the file and the field.
TransferFunction ParseTransferFunction(const nlohmann::json& json,
                                       const std::filesystem::path& file,
                                       const glm::dvec2& values_at_0_and_1);
TransferFunction ReadTransferFunction(const std::filesystem::path& path,
                                      const glm::dvec2& values_at_0_and_1);

}  // namespace tetrec
