// Facts about a triangle surface.
#pragma once

#include "mesh/triangle_mesh.h"

#include <cstdint>

namespace tetrec {

struct SurfaceFacts {
  double area = 0;
  double volume = 0;                   // signed, right where the surface is closed
  uint64_t border_edges = 0;           // of one triangle only
  uint64_t non_manifold_edges = 0;     // of three triangles or more, or wound alike in two
  uint64_t non_manifold_vertices = 0;  // whose triangles form more than one fan
  int64_t euler_characteristic = 0;    // V - E + F; 2 for a sphere, 0 for a torus

  bool IsClosedManifold() const {
    return border_edges == 0 && non_manifold_edges == 0 && non_manifold_vertices == 0;
  }
};

// Every vertex is expected to be used.
SurfaceFacts MeasureSurface(const TriangleMesh& mesh);

}  // namespace tetrec
