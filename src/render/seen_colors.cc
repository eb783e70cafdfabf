// View-dependent colour on the CPU.
#include "render/seen_colors.h"

#include "shared/harmonics.glsl.h"

#include <algorithm>

namespace tetrec {
namespace {

static_assert(kMostHarmonicsDegree == kMostHarmonicDegree &&
              HarmonicsCount(kMostHarmonicsDegree) == kMostHarmonics);

glm::vec3 ColorSeen(const glm::vec3& color, const float* coefficients, int count,
                    const glm::dvec3& direction) {
  const std::array<double, kMostHarmonics> basis = HarmonicsAt(direction);
  glm::dvec3 sum(color);
  for (int k = 0; k < count; ++k) {
    const float* c = coefficients + 3 * k;
    sum += basis[size_t(k)] * glm::dvec3(c[0], c[1], c[2]);
  }
  return glm::vec3(sum);
}

// Copies what parameters of two layouts have in common.
std::vector<float> WithComponents(const std::vector<float>& rows, const FieldLayout& from,
                                  const FieldLayout& to) {
  const size_t old_size = size_t(from.Components()), new_size = size_t(to.Components());
  std::vector<float> result(rows.size() / old_size * new_size, 0.0f);
  for (size_t row = 0; row * old_size < rows.size(); ++row) {
    for (const Attribute& attribute : to.attributes) {
      const auto same = std::ranges::find(from.attributes, attribute.name, &Attribute::name);
      if (same == from.attributes.end()) continue;
      const int count = std::min(attribute.components, same->components);
      std::copy_n(rows.begin() + long(row * old_size) + from.OffsetOf(attribute.name), count,
                  result.begin() + long(row * new_size) + to.OffsetOf(attribute.name));
    }
  }
  return result;
}

// The same for second moments.
std::vector<float> WithSecondMoments(const std::vector<float>& rows, const FieldLayout& from,
                                     const FieldLayout& to) {
  const size_t old_size = size_t(from.SecondMoments()), new_size = size_t(to.SecondMoments());
  std::vector<float> result(rows.size() / old_size * new_size, 0.0f);
  for (size_t row = 0; row * old_size < rows.size(); ++row) {
    const auto before = rows.begin() + long(row * old_size);
    const auto after = result.begin() + long(row * new_size);
    std::copy_n(before, kStandardComponents, after);
    for (size_t i = 2; i < to.attributes.size(); ++i) {
      const auto same = std::ranges::find(from.attributes, to.attributes[i].name, &Attribute::name);
      if (same == from.attributes.end()) continue;
      after[long(i) + kStandardComponents - 2] =
          before[same - from.attributes.begin() + kStandardComponents - 2];
    }
  }
  return result;
}

}  // namespace

std::array<double, 15> HarmonicsAt(const glm::dvec3& direction) {
  std::array<double, kMostHarmonics> basis{};
  if (direction == glm::dvec3(0.0)) return basis;
  for (int k = 1; k <= kMostHarmonics; ++k) {
    basis[size_t(k - 1)] = Harmonic<double>(k, direction.x, direction.y, direction.z);
  }
  return basis;
}

std::vector<glm::vec3> PlacesOfRows(const TetMesh& mesh, FieldStorage storage) {
  if (storage == FieldStorage::kVertex) return mesh.positions;
  std::vector<glm::vec3> places;
  places.reserve(mesh.tets.size());
  for (const glm::uvec4& tet : mesh.tets) {
    places.push_back(0.25f * (mesh.positions[tet[0]] + mesh.positions[tet[1]] +
                              mesh.positions[tet[2]] + mesh.positions[tet[3]]));
  }
  return places;
}

glm::dvec3 DirectionTo(const glm::dvec3& place, const glm::dvec3& center) {
  const double size = glm::length(place - center);
  return size > 0 ? (place - center) / size : glm::dvec3(0.0);
}

RadianceField FieldSeenFrom(const RadianceField& field, const glm::dvec3& center) {
  RadianceField seen = field;
  const int degree = LayoutOf(field).HarmonicsDegree();
  if (degree == 0) return seen;
  const AttributeValues& harmonics = field.others[0];
  const std::vector<glm::vec3> places = PlacesOfRows(field.mesh, field.storage);
  for (size_t row = 0; row < places.size(); ++row) {
    seen.color_srgb[row] = ColorSeen(
        field.color_srgb[row], &harmonics.values[row * size_t(harmonics.attribute.components)],
        HarmonicsCount(degree), DirectionTo(glm::dvec3(places[row]), center));
  }
  seen.others.erase(seen.others.begin());
  return seen;
}

FieldState WithHarmonics(const FieldState& state, int degree) {
  const int before = state.layout.HarmonicsDegree();
  if (before == degree) return state;
  FieldLayout layout = state.layout;
  if (before > 0) layout.attributes.erase(layout.attributes.begin() + 2);
  if (degree > 0) {
    layout.attributes.insert(layout.attributes.begin() + 2, HarmonicsAttribute(degree));
  }
  return {layout, WithComponents(state.parameters, state.layout, layout), state.first_moment,
          WithSecondMoments(state.second_moment, state.layout, layout)};
}

}  // namespace tetrec
