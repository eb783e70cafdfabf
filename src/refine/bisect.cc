// Refinement by bisection of longest edges.
#include "refine/bisect.h"

#include "geometry/orientation.h"
#include "mesh/boundary.h"
#include "refine/edited_mesh.h"

#include <map>
#include <optional>
#include <tuple>

namespace tetrec {
namespace {

struct MeasuredEdge {
  double squared_length;
  uint32_t a, b;  // a < b
  // A total order, so that no chain of longer and longer edges is endless.
  bool operator<(const MeasuredEdge& other) const {
    return std::tie(squared_length, a, b) < std::tie(other.squared_length, other.a, other.b);
  }
};

class Bisection {
 public:
  Bisection(TetMesh mesh, uint64_t budget, double min_edge)
      : is_on_boundary_(BoundaryVertices(mesh)),
        is_whole_(mesh.tets.size(), 1),
        budget_(budget),
        min_edge_(min_edge),
        mesh_(std::move(mesh)) {}

  bool HasRoom() const { return mesh_.vertices() < budget_; }

  // Returns false if the tet, whole at the start, still is.
  bool Bisect(uint32_t tet) {
    while (is_whole_[tet] && HasRoom()) {
      if (!BisectTerminal(tet)) return false;
    }
    return !is_whole_[tet];
  }
  bool IsWhole(uint32_t tet) const { return is_whole_[tet]; }

  Refinement Take() { return mesh_.Take(); }

 private:
  // Follows longer and longer edges from a tet to one that is the longest of all tets around it,
  // and halves that.
  bool BisectTerminal(uint32_t tet) {
    std::optional<MeasuredEdge> longest = LongestEdge(tet);
    while (longest) {
      const std::vector<uint32_t> around = TetsAround(*longest);
      const std::optional<MeasuredEdge> longer = LongerEdge(around, *longest);
      if (!longer) return Halve(*longest, around);
      longest = longer;
    }
    return false;
  }

  std::optional<MeasuredEdge> LongerEdge(const std::vector<uint32_t>& tets,
                                         const MeasuredEdge& edge) {
    for (const uint32_t t : tets) {
      const std::optional<MeasuredEdge> other = LongestEdge(t);
      if (other && edge < *other) return other;
    }
    return std::nullopt;
  }

  std::optional<MeasuredEdge> LongestEdge(uint32_t tet) {
    std::optional<MeasuredEdge> longest;
    for (const auto& ends : kTetEdges) {
      const MeasuredEdge edge = EdgeBetween(mesh_.tet(tet)[ends[0]], mesh_.tet(tet)[ends[1]]);
      if ((!longest || *longest < edge) && KeepsBoundary(edge)) longest = edge;
    }
    return longest;
  }

  MeasuredEdge EdgeBetween(uint32_t a, uint32_t b) const {
    const glm::dvec3 way = glm::dvec3(mesh_.position(b)) - glm::dvec3(mesh_.position(a));
    return {glm::dot(way, way), std::min(a, b), std::max(a, b)};
  }

  std::vector<uint32_t> TetsAround(const MeasuredEdge& edge) const {
    return mesh_.TetsAround(edge.a, edge.b);
  }

  // The third vertices of the boundary's faces at an edge: two, or none if it is inside.
  std::vector<uint32_t> BoundaryAt(const MeasuredEdge& edge) const {
    if (!is_on_boundary_[edge.a] || !is_on_boundary_[edge.b]) return {};
    std::map<uint32_t, int> faces;
    for (const uint32_t t : TetsAround(edge)) {
      for (int i = 0; i < 4; ++i) {
        const uint32_t v = mesh_.tet(t)[i];
        if (v != edge.a && v != edge.b) ++faces[v];
      }
    }
    std::vector<uint32_t> thirds;
    for (const auto& [third, tets] : faces) {
      if (tets == 1) thirds.push_back(third);
    }
    return thirds;
  }

  // The middle is exactly in the boundary's faces at the edge.
  bool KeepsBoundary(const MeasuredEdge& edge) const {
    for (const uint32_t third : BoundaryAt(edge)) {
      if (Orientation(mesh_.position(edge.a), mesh_.position(edge.b), mesh_.position(third),
                      mesh_.Middle(edge.a, edge.b)) != 0) {
        return false;
      }
    }
    return true;
  }

  bool Halve(const MeasuredEdge& edge, const std::vector<uint32_t>& around) {
    if (edge.squared_length < min_edge_ * min_edge_) return false;
    const bool is_on_boundary = !BoundaryAt(edge).empty();
    if (!mesh_.Halve(edge.a, edge.b, around)) return false;
    is_on_boundary_.push_back(uint8_t(is_on_boundary));
    for (const uint32_t t : around) {
      is_whole_[t] = 0;
      is_whole_.push_back(0);
    }
    return true;
  }

  std::vector<uint8_t> is_on_boundary_;  // of each vertex
  std::vector<uint8_t> is_whole_;        // of each tet: it was there from the start
  uint64_t budget_;
  double min_edge_;
  EditedMesh mesh_;
};

}  // namespace

Refinement BisectTets(TetMesh mesh, const RefineScores& scores, const RefineOptions& options) {
  const uint64_t budget = VertexBudget(mesh.positions.size(), options);
  Bisection bisection(std::move(mesh), budget, options.min_edge);
  uint64_t refused = 0;
  for (const uint32_t tet : WorstFirst(scores.of_tets)) {
    if (!bisection.HasRoom() || !(scores.of_tets[tet] > 0.0f)) break;
    if (bisection.IsWhole(tet) && !bisection.Bisect(tet)) ++refused;
  }
  Refinement result = bisection.Take();
  result.refused = refused;
  return result;
}

}  // namespace tetrec
