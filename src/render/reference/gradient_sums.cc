// The sums of gradients since the last update, on the CPU.
#include "render/reference/gradient_sums.h"

#include "core/error.h"
#include "render/seen_colors.h"

#include <algorithm>
#include <utility>

namespace tetrec {

ReferenceSums::ReferenceSums(const RadianceField& field) : standard_(field) {
  const FieldLayout layout = LayoutOf(field);
  components_ = size_t(layout.Components());
  harmonics_degree_ = layout.HarmonicsDegree();
  others_.resize(standard_.density.size() * (components_ - kStandardComponents));
}

double& ReferenceSums::At(size_t row, size_t component) {
  if (component < kDensityOffset) return standard_.color_srgb[row][int(component)];
  if (component == kDensityOffset) return standard_.density[row];
  return others_[row * (components_ - kStandardComponents) + component - kStandardComponents];
}

void ReferenceSums::Add(const ReferenceGradient& gradient, const RadianceField& field,
                        const glm::dvec3& center, bool with_positions) {
  const size_t others = components_ - kStandardComponents;
  const size_t count = size_t(HarmonicsCount(harmonics_degree_));
  const std::vector<glm::vec3> places = PlacesOfRows(field.mesh, field.storage);
  for (size_t row = 0; row < places.size(); ++row) {
    standard_.color_srgb[row] += gradient.color_srgb[row];
    standard_.density[row] += gradient.density[row];
    const auto basis = HarmonicsAt(DirectionTo(glm::dvec3(places[row]), center));
    for (size_t i = 0; i < 3 * count; ++i) {
      others_[row * others + i] += basis[i / 3] * gradient.color_srgb[row][int(i % 3)];
    }
  }
  for (size_t v = 0; v < gradient.position.size(); ++v) {
    standard_.position[v] += gradient.position[v];
    standard_.absolute_position[v] += gradient.absolute_position[v];
  }
  has_positions_ |= with_positions;
}

void ReferenceSums::Add(const GradientSums& given) {
  const size_t rows = standard_.density.size(), vertices = standard_.position.size();
  TETREC_CHECK(given.values.size() == rows * components_, "one gradient per component");
  TETREC_CHECK(given.position.size() == given.absolute_position.size() &&
                   (given.position.empty() || given.position.size() == vertices),
               "one gradient per position, or none");
  for (size_t row = 0; row < rows; ++row) {
    for (size_t c = 0; c < components_; ++c) At(row, c) += given.values[row * components_ + c];
  }
  for (size_t v = 0; v < given.position.size(); ++v) {
    standard_.position[v] += given.position[v];
    standard_.absolute_position[v] += given.absolute_position[v];
  }
  has_positions_ |= !given.position.empty();
}

GradientSums ReferenceSums::Take() {
  GradientSums result = TakePositions();
  const size_t rows = standard_.density.size();
  result.values.resize(rows * components_);
  for (size_t row = 0; row < rows; ++row) {
    for (size_t c = 0; c < components_; ++c) result.values[row * components_ + c] = At(row, c);
  }
  ClearValues();
  return result;
}

GradientSums ReferenceSums::TakePositions() {
  GradientSums result;
  if (!std::exchange(has_positions_, false)) return result;
  const size_t vertices = standard_.position.size();
  result.position = std::exchange(standard_.position, std::vector<glm::dvec3>(vertices));
  result.absolute_position =
      std::exchange(standard_.absolute_position, std::vector<double>(vertices));
  return result;
}

void ReferenceSums::ClearValues() {
  std::fill(standard_.color_srgb.begin(), standard_.color_srgb.end(), glm::dvec3(0.0));
  std::fill(standard_.density.begin(), standard_.density.end(), 0.0);
  std::fill(others_.begin(), others_.end(), 0.0);
}

}  // namespace tetrec
