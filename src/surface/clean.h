// Cleaning of a raw surface: small pieces are dropped, fans that meet in a point are separated.
#pragma once

#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace tetrec {

struct CleanOptions {
  double min_component_share = 0.002;  // share of the largest piece's area below which pieces go
  bool keep_cavities = false;          // closed pieces that face inward, unseen from outside
  // Centres of cameras: a closed piece that contains one of them is a room, not a cavity.
  std::vector<glm::dvec3> cameras;
};

struct CleanResult {
  TriangleMesh mesh;
  uint64_t components = 0;  // pieces of the input
  uint64_t dropped_small = 0, dropped_cavities = 0;
  uint64_t dropped_triangles = 0;
};

// Drops small pieces (connected by shared vertices) and cavities; the rest keeps its order. With
// `main_part`, pieces are compared with the largest one of that mesh instead of their own.
CleanResult KeepLargePieces(const TriangleMesh& mesh, const CleanOptions& options,
                            const TriangleMesh* main_part = nullptr);

// Where several fans of triangles meet in one vertex, as on the rim of a cropped level set, gives
// each fan its own copy of the vertex. Edges of more than two triangles are left alone.
TriangleMesh SeparateFans(const TriangleMesh& mesh);

}  // namespace tetrec
