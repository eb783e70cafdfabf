// The quality of tets, and a regulariser that keeps vertices from spoiling it.
#include "mesh/tet_quality.h"

#include <cmath>
#include <iterator>
#include <numbers>

namespace tetrec {
namespace {

// Q = kScale V / S^(3/2), S = the sum of the squared lengths of the edges = 6 l_rms^2.
const double kScale = 6 * std::numbers::sqrt2 * std::pow(6.0, 1.5);

double SumOfSquares(const TetCorners& p) {
  double sum = 0;
  for (const auto& ends : kTetEdges) {
    const glm::dvec3 edge = p[size_t(ends[1])] - p[size_t(ends[0])];
    sum += glm::dot(edge, edge);
  }
  return sum;
}

// ln(1 + e^x) without overflow.
double LogOnePlusExp(double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); }

}  // namespace

TetCorners CornersOf(std::span<const glm::vec3> positions, const glm::uvec4& tet) {
  TetCorners corners;
  for (int i = 0; i < 4; ++i) corners[size_t(i)] = glm::dvec3(positions[tet[i]]);
  return corners;
}

double SignedVolume(const TetCorners& p) {
  return glm::dot(p[1] - p[0], glm::cross(p[2] - p[0], p[3] - p[0])) / 6;
}

double MeanEdge(const TetCorners& p) {
  double sum = 0;
  for (const auto& ends : kTetEdges) sum += glm::distance(p[size_t(ends[0])], p[size_t(ends[1])]);
  return sum / double(std::size(kTetEdges));
}

double ParthasarathyQuality(const TetCorners& corners) {
  const double squares = SumOfSquares(corners);
  return squares > 0 ? kScale * SignedVolume(corners) / (squares * std::sqrt(squares)) : 0.0;
}

// dQ = kScale (dV S^(-3/2) - 3/2 V dS S^(-5/2)).
TetCorners ParthasarathyGradient(const TetCorners& corners) {
  const double squares = SumOfSquares(corners);
  TetCorners gradient{};
  if (!(squares > 0)) return gradient;
  const double by_volume = kScale / (squares * std::sqrt(squares));
  const double by_squares = -1.5 * by_volume * SignedVolume(corners) / squares;
  for (size_t i = 0; i < 4; ++i) {
    // dV/dp_i is a third of the opposite face's area, inwards.
    const auto& face = kFaceVertices[i];
    const glm::dvec3 &a = corners[size_t(face[0])], &b = corners[size_t(face[1])],
                     &c = corners[size_t(face[2])];
    const glm::dvec3 volume_slope = -glm::cross(b - a, c - a) / 6.0;
    const glm::dvec3 squares_slope = 2.0 * (3.0 * corners[i] - a - b - c);
    gradient[i] = by_volume * volume_slope + by_squares * squares_slope;
  }
  return gradient;
}

double RegulariserOf(const TetMesh& mesh, const QualityRegulariser& regulariser) {
  double sum = 0;
  for (const glm::uvec4& tet : mesh.tets) {
    const double quality = ParthasarathyQuality(CornersOf(mesh.positions, tet));
    sum += LogOnePlusExp(-regulariser.sharpness * quality) / regulariser.sharpness;
  }
  return regulariser.strength * sum;
}

std::vector<glm::dvec3> RegulariserGradients(const TetMesh& mesh,
                                             const QualityRegulariser& regulariser) {
  std::vector<glm::dvec3> gradients(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec4& tet : mesh.tets) {
    const TetCorners corners = CornersOf(mesh.positions, tet);
    const double quality = ParthasarathyQuality(corners);
    const double slope = -regulariser.strength / (1 + std::exp(regulariser.sharpness * quality));
    const TetCorners of_quality = ParthasarathyGradient(corners);
    for (int i = 0; i < 4; ++i) gradients[tet[i]] += slope * of_quality[size_t(i)];
  }
  return gradients;
}

}  // namespace tetrec
