// A field as an optimiser sees it: parameters and moments, row by row.
#include "field/field_state.h"

#include "core/error.h"

#include <cmath>

namespace tetrec {
namespace {

float MixParameters(const Attribute& attribute, float a, float b, float share) {
  return ParameterOf(attribute, glm::mix(ValueOf(attribute, a), ValueOf(attribute, b), share));
}

// `rows`: of `width` values each; `mix`: of component, two values and share.
template <class Mix>
std::vector<float> ProlongRows(std::vector<float> rows, size_t width,
                               const Prolongation& prolongation, const Mix& mix) {
  rows.reserve(rows.size() + prolongation.inserted.size() * width);
  for (const auto [a, b, share] : prolongation.inserted) {
    for (size_t c = 0; c < width; ++c) {
      rows.push_back(mix(c, rows[a * width + c], rows[b * width + c], share));
    }
  }
  std::vector<float> result;
  result.reserve(prolongation.kept.size() * width);
  for (const uint32_t row : prolongation.kept) {
    result.insert(result.end(), rows.data() + row * width, rows.data() + (row + 1) * width);
  }
  return result;
}

}  // namespace

Attribute DensityOfValues(const RadianceField& field) {
  double sum = 0;
  bool is_signed = false;
  for (const float value : field.density) {
    sum += std::abs(double(value));
    is_signed = is_signed || value < 0;
  }
  return is_signed ? SignedDensity(float(sum / double(field.density.size()))) : kDensityAttribute;
}

FieldState StateOf(const RadianceField& field, const Attribute& density) {
  FieldState state = WithoutMoments(LayoutOf(field), ValuesOf(field));
  state.layout.attributes[1] = density;
  CheckLayout(state.layout);
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  for (size_t i = 0; i < state.parameters.size(); ++i) {
    float& parameter = state.parameters[i];
    parameter = ParameterOf(*attributes[i % attributes.size()], parameter);
  }
  return state;
}

FieldState WithoutMoments(FieldLayout layout, std::vector<float> parameters) {
  FieldState state{.layout = std::move(layout), .parameters = std::move(parameters)};
  const size_t rows = state.rows();
  state.first_moment.assign(rows * size_t(FieldLayout::FirstMoments()), 0.0f);
  state.second_moment.assign(rows * size_t(state.layout.SecondMoments()), 0.0f);
  return state;
}

RadianceField FieldOf(TetMesh mesh, const FieldState& state) {
  std::vector<float> values = state.parameters;
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = ValueOf(*attributes[i % attributes.size()], values[i]);
  }
  RadianceField field = MakeField(std::move(mesh), state.layout, values);
  CheckField(field);
  return field;
}

FieldState Prolong(const FieldState& state, const Prolongation& prolongation) {
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  const auto by_value = [&](size_t c, float a, float b, float share) {
    return MixParameters(*attributes[c], a, b, share);
  };
  const auto mix = [](size_t, float a, float b, float share) { return glm::mix(a, b, share); };
  return {.layout = state.layout,
          .parameters = ProlongRows(state.parameters, attributes.size(), prolongation, by_value),
          .first_moment = ProlongRows(state.first_moment, size_t(FieldLayout::FirstMoments()),
                                      prolongation, mix),
          .second_moment = ProlongRows(state.second_moment, size_t(state.layout.SecondMoments()),
                                       prolongation, mix)};
}

}  // namespace tetrec
