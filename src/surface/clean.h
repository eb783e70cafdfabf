// What is kept of a raw surface: large pieces, fewer triangles.
#pragma once

#include "geometry/rigid3.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>

namespace tetrec {

struct CleanOptions {
  double min_component_share = 0.01;  // of the largest piece's area; smaller pieces are dropped
  bool keep_cavities = false;  // closed pieces that face inward: no view from outside sees them
};

struct CleanResult {
  TriangleMesh mesh;
  uint64_t components = 0;  // before
  uint64_t dropped_small = 0, dropped_cavities = 0;
  uint64_t dropped_triangles = 0;
};

// Drops pieces (connected by shared vertices) by area; ties and order follow the input.
CleanResult KeepLargePieces(const TriangleMesh& mesh, const CleanOptions& options);

// Gives each fan of triangles a vertex of its own where several fans meet in one vertex, as they
// may where a level set was cropped. Edges of more than two triangles stay as they are.
TriangleMesh SeparateFans(const TriangleMesh& mesh);

// Collapses edges by quadric error down to max_triangles; borders and manifoldness are kept, so
// that it may end above. Vertices keep their positions and colours. Method: Garland and Heckbert
// 1997, by OpenMesh. Throws DataError where the mesh is not a manifold.
TriangleMesh Decimate(const TriangleMesh& mesh, uint64_t max_triangles);

}  // namespace tetrec
