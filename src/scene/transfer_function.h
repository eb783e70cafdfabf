// Transfer functions: opacity and colour of a volume's samples, piecewise linear in the normalised
// sample, constant before the first and behind the last position.
//
// Our format: {"opacity": [[x, opacity]...], "colour": [[x, r, g, b]...]}, all in [0, 1], x rising
// strictly; colours are given in sRGB and interpolated in linear RGB. ParaView's: an array of one
// colour map with "ColorSpace": "RGB", "RGBPoints": [x, r, g, b...] and "Points": [x, opacity,
// midpoint, sharpness...] with midpoint 0.5 and sharpness 0; positions are
// values of the samples, unless the map spans exactly 0 to 1, then normalised ones; colours are
// interpolated as they are given, in sRGB.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <vector>

namespace tetrec {

// In which space colours are linear between two positions.
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
  // True where the file's positions are values of the samples: these hold whatever becomes 0 and 1.
  bool given_in_values = false;

  double OpacityAt(double x) const;
  glm::dvec3 SrgbAt(double x) const;  // display sRGB
  // Where opacity is above 0: begin and end of each stretch, rising.
  std::vector<glm::dvec2> OpaqueStretches() const;
};

// Either format, told by the outermost bracket; `values_at_0_and_1` are those that normalised
// samples of 0 and 1 stand for. Throws DataError naming the file and the field.
TransferFunction ParseTransferFunction(const nlohmann::json& json,
                                       const std::filesystem::path& file,
                                       const glm::dvec2& values_at_0_and_1);
TransferFunction ReadTransferFunction(const std::filesystem::path& path,
                                      const glm::dvec2& values_at_0_and_1);

}  // namespace tetrec
