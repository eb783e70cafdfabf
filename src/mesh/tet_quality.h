// The quality of tets, and a regulariser that keeps vertices from spoiling it.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <array>
#include <span>
#include <vector>

namespace tetrec {

using TetCorners = std::array<glm::dvec3, 4>;

TetCorners CornersOf(std::span<const glm::vec3> positions, const glm::uvec4& tet);
double SignedVolume(const TetCorners& corners);  // positive for a positively oriented tet
double MeanEdge(const TetCorners& corners);      // length

// Q = 6 sqrt(2) V / l_rms^3 of the signed volume and the root of the mean of the squared lengths of
// the six edges: 1 for a regular tet, 0 for a flat one, negative for one that is inside out. It
// does not depend on the tet's size. 0 for a tet that is a point. (Parthasarathy, Graichen and
// Hathaway, "Fast evaluation & improvement of tetrahedral 3-D grid quality", 1991.)
double ParthasarathyQuality(const TetCorners& corners);

// dQ/dcorner; 0 for a tet that is a point.
TetCorners ParthasarathyGradient(const TetCorners& corners);

// R = strength x the sum over the tets of softplus(-Q), softplus(x) = ln(1 + e^(sharpness x)) /
// sharpness (DiffTetVR, section 6, with the sign of Q that penalises bad tets).
struct QualityRegulariser {
  double strength = 10;    // lambda of the article
  double sharpness = 100;  // beta of the article; tets of Q above a few 1 / beta feel little
};

double RegulariserOf(const TetMesh& mesh, const QualityRegulariser& regulariser);

// (V) dR/dposition [1 / world unit].
std::vector<glm::dvec3> RegulariserGradients(const TetMesh& mesh,
                                             const QualityRegulariser& regulariser);

}  // namespace tetrec
