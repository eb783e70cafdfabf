// A field as an optimiser sees it: parameters and moments, row by row.
#pragma once

#include "field/radiance_field.h"

#include <glm/common.hpp>

#include <cstdint>
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

// A row at `share` of the way from row `a` to row `b`.
struct RowSource {
  uint32_t a, b;
  float share;
};

// How the rows of a new field come from those of an old one: the inserted rows are put behind the
// old ones, each between two rows before it, and then row i of the new field is row kept[i] of all
// these.
struct Prolongation {
  std::vector<RowSource> inserted;
  std::vector<uint32_t> kept;
};

// Linear interpolation of the values, whose parameters need not be linear, and of the moments.
FieldState Prolong(const FieldState& state, const Prolongation& prolongation);

// The same for other values, one per row, that interpolate linearly.
template <class T>
std::vector<T> Prolong(std::vector<T> values, const Prolongation& prolongation) {
  for (const auto [a, b, share] : prolongation.inserted) {
    values.push_back(glm::mix(values[a], values[b], share));
  }
  std::vector<T> result;
  result.reserve(prolongation.kept.size());
  for (const uint32_t row : prolongation.kept) result.push_back(values[row]);
  return result;
}

}  // namespace tetrec
