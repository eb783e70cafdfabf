// What a triangle mesh is made of: counts, pieces, whether it is closed.
#pragma once

#include "geometry/bounds3.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>

namespace tetrec {

struct MeshFacts {
  uint64_t vertices = 0, faces = 0;
  uint64_t components = 0;  // pieces connected through shared vertices; lone vertices do not count
  uint64_t boundary_edges = 0;  // edges of one face
  uint64_t non_manifold_edges =
      0;                    // edges of more than two faces, or of two that disagree on outside
  bool watertight = false;  // has faces, and every edge has two that agree
  double area = 0;          // [square units of the mesh]
  double volume = 0;        // [cubic units]; 0 where not watertight
  Bounds3 bounds;           // of all vertices
};

MeshFacts MeasureMesh(const TriangleMesh& mesh);

}  // namespace tetrec
