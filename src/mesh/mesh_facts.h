// Facts about a triangle mesh: counts, pieces, whether it is closed, area and volume.
#pragma once

#include "geometry/bounds3.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace tetrec {

// Vertices that no triangle uses count only in `vertices` and `bounds`.
struct MeshFacts {
  uint64_t vertices = 0, faces = 0;
  uint64_t components = 0;          // pieces connected through shared vertices
  uint64_t boundary_edges = 0;      // edges of one triangle
  uint64_t non_manifold_edges = 0;  // edges of three or more triangles, or of two inconsistent ones
  uint64_t non_manifold_vertices = 0;  // vertices whose triangles form more than one fan
  int64_t euler_characteristic = 0;    // V - E + F; 2 for a sphere, 0 for a torus
  bool watertight = false;  // has triangles, and every edge has two of consistent winding
  double area = 0;          // [square units of the mesh]
  double volume = 0;        // [cubic units], negative if inside out; 0 unless watertight
  Bounds3 bounds;           // of all vertices

  bool IsClosedManifold() const { return watertight && non_manifold_vertices == 0; }
};

MeshFacts MeasureMesh(const TriangleMesh& mesh);

// (V) The smallest vertex of the piece that each vertex belongs to; pieces are connected through
// shared vertices.
std::vector<uint32_t> PieceOfVertex(const TriangleMesh& mesh);

}  // namespace tetrec
