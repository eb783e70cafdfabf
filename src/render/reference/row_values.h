// The values of a field's rows, and the parameters that they come from.
#pragma once

#include "field/field_state.h"

#include <cstddef>

namespace tetrec {

// Gives a row of the field the values of its parameters. Both have the same layout.
template <class Real>
void SpreadRow(const FieldState& state, size_t row, RadianceField& field) {
  const size_t components = size_t(state.layout.Components());
  const float* parameters = &state.parameters[row * components];
  field.density[row] = float(ValueOf(state.layout.density(), Real(parameters[kDensityOffset])));
  for (int c = 0; c < 3; ++c) field.color_srgb[row][c] = parameters[kColorOffset + c];
  const float* parameter = parameters + kStandardComponents;
  for (AttributeValues& other : field.others) {
    const size_t count = size_t(other.attribute.components);
    for (size_t c = 0; c < count; ++c) {
      other.values[row * count + c] = ValueOf(other.attribute, *parameter++);
    }
  }
}

}  // namespace tetrec
