// What the values at vertices show.
#include "refine/vertex_values.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

double SignedOpacity(double density, double length) {
  return std::copysign(-std::expm1(-std::abs(density) * length), density);
}

}  // namespace

std::vector<glm::dvec4> ValuesAtVertices(const FieldState& state) {
  std::vector<glm::dvec4> values(state.rows());
  const size_t components = size_t(state.layout.Components());
  for (size_t v = 0; v < values.size(); ++v) {
    const float* row = state.parameters.data() + v * components;
    for (int c = 0; c < 3; ++c) values[v][c] = double(row[kColorOffset + c]);
    values[v].a = double(ValueOf(state.layout.density(), row[kDensityOffset]));
  }
  return values;
}

double Opacity(double density, double length) {
  return -std::expm1(-std::max(0.0, density) * length);
}

double SquaredChange(const glm::dvec4& a, const glm::dvec4& b, double length) {
  const glm::dvec3 color(a - b);
  const double opacity = SignedOpacity(a.a, length) - SignedOpacity(b.a, length);
  return glm::dot(color, color) + opacity * opacity;
}

}  // namespace tetrec
