// A field as an optimiser sees it: parameters and moments, row by row.
#include "field/field_state.h"

#include "core/error.h"

#include <cmath>

namespace tetrec {
namespace {

float MixParameters(const Attribute& attribute, float a, float b, float share) {
  return ParameterOf(attribute, glm::mix(ValueOf(attribute, a), ValueOf(attribute, b), share));
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
  FieldState state{.layout = LayoutOf(field), .parameters = ValuesOf(field)};
  state.layout.attributes[1] = density;
  CheckLayout(state.layout);
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  for (size_t i = 0; i < state.parameters.size(); ++i) {
    float& parameter = state.parameters[i];
    parameter = ParameterOf(*attributes[i % attributes.size()], parameter);
  }
  state.first_moment.assign(state.parameters.size(), 0.0f);
  state.second_moment.assign(state.parameters.size(), 0.0f);
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

FieldState Prolong(const FieldState& state, std::span<const RowSource> sources) {
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  const size_t components = attributes.size();
  FieldState result{.layout = state.layout};
  for (auto* values : {&result.parameters, &result.first_moment, &result.second_moment}) {
    values->reserve(sources.size() * components);
  }
  for (const auto [a, b, share] : sources) {
    for (size_t c = 0; c < components; ++c) {
      const size_t at = a * components + c, bt = b * components + c;
      result.parameters.push_back(a == b ? state.parameters[at]
                                         : MixParameters(*attributes[c], state.parameters[at],
                                                         state.parameters[bt], share));
      result.first_moment.push_back(
          glm::mix(state.first_moment[at], state.first_moment[bt], share));
      result.second_moment.push_back(
          glm::mix(state.second_moment[at], state.second_moment[bt], share));
    }
  }
  return result;
}

}  // namespace tetrec
