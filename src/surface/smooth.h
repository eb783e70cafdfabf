// A surface without the ripples of its reconstruction.
#pragma once

#include "mesh/triangle_mesh.h"

namespace tetrec {

struct SmoothOptions {
  int rounds = 10;  // of normals, each with the neighbours that share a vertex; 0: none
  // Normals count for each other if they differ by little more than this, as the length of the
  // difference of unit vectors: about 20 degrees.
  double edge_width = 0.35;
  double max_move = 0;  // of a vertex [units of the mesh]; 0: none
};

// Averages the triangles' normals where they are alike, so that edges of the shape stay, and then
// moves vertices until the triangles have these normals. Along the normals alone: outlines and
// volume stay, unlike with averaged positions. Vertices at borders stay where they are, and moves
// are shortened where the surface would cross itself (StepBackFromCrossings). Methods: Zheng et
// al., Bilateral Normal Filtering for Mesh Denoising, 2011 (local scheme, weights by area); Sun et
// al., Fast and Effective Feature-Preserving Mesh Denoising, 2007 (vertices).
TriangleMesh SmoothByNormals(TriangleMesh mesh, const SmoothOptions& options);

}  // namespace tetrec
