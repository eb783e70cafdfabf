// What the values at vertices show.
#pragma once

#include "refine/refine.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

// (V) Colour and density (values, not parameters) of the vertices of a field with a row each.
std::vector<glm::dvec4> ValuesAtVertices(const FieldState& state);

// The share of its light that a ray loses over a length [world units] of constant density; 0 where
// the density is negative.
double Opacity(double density, double length);

// How visible the difference between two values (colour and density) is over a length [world
// units]: the sum of the squared differences of colours and of opacities. Opacities have the sign
// of their density, because how far below 0 a value is decides where the surface between it and a
// positive one lies.
double SquaredChange(const glm::dvec4& a, const glm::dvec4& b, double length);

}  // namespace tetrec
