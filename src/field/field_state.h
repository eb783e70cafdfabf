// A field as an optimiser sees it: parameters and moments, row by row.
#pragma once

#include "field/radiance_field.h"

#include <span>
#include <vector>

namespace tetrec {

struct FieldState {
  FieldLayout layout;
  std::vector<float> parameters;  // rows x layout.Components()
  // Adam's, for colour and density: rows x layout.FirstMoments().
  std::vector<float> first_moment;
  // Rows x layout.SecondMoments(): those of Adam, then one per attribute behind density
  // (shared/adam.glsl.h).
  std::vector<float> second_moment;

  size_t rows() const { return parameters.size() / size_t(layout.Components()); }
};

// All moments are 0, as before any learning.
FieldState WithoutMoments(FieldLayout layout, std::vector<float> parameters);

// The density attribute that has a parameter for each value of the field: signed if one of them is
// negative.
Attribute DensityOfValues(const RadianceField& field);

// The field's values as parameters, and moments of 0. `density` is kDensityAttribute or a signed
// one.
FieldState StateOf(const RadianceField& field, const Attribute& density);
inline FieldState StateOf(const RadianceField& field) {
  return StateOf(field, DensityOfValues(field));
}

// The field that a state describes. Throws DataError as CheckField.
RadianceField FieldOf(TetMesh mesh, const FieldState& state);

// A row of a new field: at `share` of the way from row `a` to row `b` of an old one.
struct RowSource {
  uint32_t a, b;
  float share;
};

// Linear interpolation of the values, whose parameters need not be linear, and of the moments. A
// row whose ends are one is copied.
FieldState Prolong(const FieldState& state, std::span<const RowSource> sources);

}  // namespace tetrec
