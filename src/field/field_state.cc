// A field as an optimiser sees it: parameters and moments, row by row.
#include "field/field_state.h"

#include "core/error.h"

#include <cmath>

namespace tetrec {
namespace {

float MixParameters(const Attribute& attribute, float a, float b, float share) {
  return ParameterOf(attribute, glm::mix(ValueOf(attribute, a), ValueOf(attribute, b), share));
}

std::vector<float> MixRows(const std::vector<float>& rows, size_t width,
                           std::span<const RowSource> sources) {
  std::vector<float> result;
  result.reserve(sources.size() * width);
  for (const auto [a, b, share] : sources) {
    for (size_t c = 0; c < width; ++c) {
      result.push_back(glm::mix(rows[a * width + c], rows[b * width + c], share));
    }
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

FieldState Prolong(const FieldState& state, std::span<const RowSource> sources) {
  const std::vector<const Attribute*> attributes = state.layout.ByComponent();
  const size_t components = attributes.size();
  FieldState result{.layout = state.layout};
  result.parameters.reserve(sources.size() * components);
  for (const auto [a, b, share] : sources) {
    for (size_t c = 0; c < components; ++c) {
      const size_t at = a * components + c, bt = b * components + c;
      result.parameters.push_back(a == b ? state.parameters[at]
                                         : MixParameters(*attributes[c], state.parameters[at],
                                                         state.parameters[bt], share));
    }
  }
  result.first_moment = MixRows(state.first_moment, size_t(FieldLayout::FirstMoments()), sources);
  result.second_moment =
      MixRows(state.second_moment, size_t(state.layout.SecondMoments()), sources);
  return result;
}

}  // namespace tetrec
