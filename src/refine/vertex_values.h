// What vertices and tets show, for the choice of vertices that a mesh can do without.
#pragma once

#include "refine/refine.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace tetrec {

// (V) Colour and density (values, not parameters) of the vertices of a field with a row each.
std::vector<glm::dvec4> ValuesAtVertices(const FieldState& state);

// What a ray loses over a length [world units] of constant density; nothing where that is negative.
double Opacity(double density, double length);

// How much one value (colour and density) shows instead of another over a length [world units]: the
// sum of the squared differences of colours and of opacities. Opacities have the sign of their
// density, because how far below 0 a value is decides where the surface between it and a positive
// one lies.
double SquaredChange(const glm::dvec4& a, const glm::dvec4& b, double length);

// (V) 1 for vertices that must stay: those of the hull, and those of scores.is_kept.
std::vector<uint8_t> FixedVertices(const TetMesh& mesh, const RefineScores& scores);

using TetCorners = std::array<glm::dvec3, 4>;
double MeanEdge(const TetCorners& corners);

// The share of a vertex's values in what is seen in a tet at it, on average.
inline constexpr double kShareOfVertex = 0.25;

}  // namespace tetrec
