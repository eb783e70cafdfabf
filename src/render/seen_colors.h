// View-dependent colour on the CPU: what a field shows to a camera.
#pragma once

#include "field/field_state.h"

#include <glm/glm.hpp>

#include <array>
#include <vector>

namespace tetrec {

// Y_1 to Y_15 of shared/harmonics.glsl.h; all 0 for the zero vector.
std::array<double, 15> HarmonicsAt(const glm::dvec3& direction);

// What the rows of attributes belong to: vertices, or centroids of tets.
std::vector<glm::vec3> PlacesOfRows(const TetMesh& mesh, FieldStorage storage);

// The unit vector from a camera's centre to a place; 0 if they coincide.
glm::dvec3 DirectionTo(const glm::dvec3& place, const glm::dvec3& center);

// The field with the colours that a camera at `center` sees, which do not depend on the view. A
// field without harmonics is returned as it is.
RadianceField FieldSeenFrom(const RadianceField& field, const glm::dvec3& center);

// The state with view-dependent colour of another degree: coefficients that it did not have are 0;
// those that it does not keep are forgotten. Their moment stays, and is 0 for a first degree.
FieldState WithHarmonics(const FieldState& state, int degree);

}  // namespace tetrec
