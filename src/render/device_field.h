// A field on the device: mesh, parameters, gradients, the state of Adam.
#pragma once

#include "gpu/buffer.h"
#include "render/renderer.h"

#include <span>
#include <string>

namespace tetrec {

// 32 bytes a tet, 32 a vertex, and 64 more a row of attributes to learn (80 in fixed point); 16
// more a tet where cells have the attributes; one plane and one triangle a boundary face, and over
// them the planes of a convex boundary of few faces, of any other a tree of boxes.
struct DeviceField {
  TetMesh mesh;            // the host's copy
  std::string not_convex;  // why the boundary is not convex; empty where it is
  glm::vec4 ball{0.0f};    // centre, radius: holds the mesh
  Buffer tets, vertices, hull;
  Buffer parameters, moments, gradients;
  Buffer position_gradients;  // vec4 a vertex: xyz | absolute sum; absent until asked for
  Buffer tet_scores;
  uint32_t vertex_count = 0, tet_count = 0, hull_faces = 0, hull_planes = 0;
  FieldStorage storage = FieldStorage::kVertex;
  uint32_t row_count = 0;    // of parameters, moments, gradients: vertex_count or tet_count
  uint32_t first_cell = 0;   // row of tet 0 in `vertices`, behind those of the vertices
  uint32_t tree_leaves = 0;  // of the tree of boxes; 0 where there is none
  bool fixed_point = false;  // gradients, position_gradients, tet_scores: int64 in place of float
  uint32_t most_tets_at_vertex = 0;
  double diagonal = 0;  // of the mesh's bounds [world units]
};

// What a field takes on the device for one tet, vertex, boundary face, at most: position gradients
// and a tree of boxes are counted in.
struct DeviceFieldBytes {
  uint64_t of_tet, of_vertex, of_face;
};
DeviceFieldBytes BytesOf(FieldStorage storage, bool fixed_point);

// Gradients and scores start at zero; so do the moments where `state` has none. Density and colour
// in `vertices` are yet to be spread from the parameters (spread.comp).
DeviceField UploadField(const Device& device, const TetMesh& mesh, const VertexState& state,
                        bool fixed_point);

// Sums in units of value, 4 a row: `quanta` are those of xyz and of w.
std::vector<glm::vec4> DownloadRowSums(const DeviceField& field, const Buffer& sums, uint32_t rows,
                                       glm::dvec2 quanta);
// Tet scores.
std::vector<float> DownloadScores(const DeviceField& field);

// Makes position_gradients, zero, where it is absent.
void AllocatePositionGradients(const Device& device, DeviceField& field);

// Parameters and moments. The device must not be using them.
VertexState DownloadState(const DeviceField& field);

}  // namespace tetrec
