// What surrounds the vertices of a surface.
#pragma once

#include "mesh/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// The triangles at each vertex.
class VertexFans {
 public:
  explicit VertexFans(const TriangleMesh& mesh);

  std::span<const uint32_t> At(size_t vertex) const {
    return std::span(triangles_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
  }

 private:
  std::vector<uint32_t> begin_, triangles_;  // one list after the other
};

// (V) True for the ends of edges that only one triangle has.
std::vector<bool> BorderVertices(const TriangleMesh& mesh);

}  // namespace tetrec
