// A field on the device: mesh, parameters, gradients, the state of Adam.
#pragma once

#include "gpu/buffer.h"
#include "render/renderer.h"

#include <span>

namespace tetrec {

// 32 bytes a tet, 32 a vertex, and 64 more a vertex to learn (80 in fixed point); the hull as one
// plane and one triangle a boundary face (gpu_types.glsl.h tells the layouts).
struct DeviceField {
  TetMesh mesh;  // the host's copy
  Buffer tets, vertices, hull;
  Buffer parameters, moments, gradients;
  Buffer position_gradients;  // vec4 a vertex: xyz | absolute sum; absent until asked for
  Buffer tet_scores;
  uint32_t vertex_count = 0, tet_count = 0, hull_faces = 0;
  bool fixed_point = false;  // gradients, position_gradients, tet_scores: int64 in place of float
  uint32_t most_tets_at_vertex = 0;
  double diagonal = 0;  // of the mesh's bounds [world units]
};

// Gradients and scores start at zero; so do the moments where `state` has none. Density and colour
// of `vertices` are yet to be spread from the parameters (spread.comp).
DeviceField UploadField(const Device& device, const TetMesh& mesh, const VertexState& state,
                        bool fixed_point);

// Sums in units of value, 4 a vertex: `quanta` are those of xyz and of w.
std::vector<glm::vec4> DownloadVertexSums(const DeviceField& field, const Buffer& sums,
                                          glm::dvec2 quanta);
// Tet scores.
std::vector<float> DownloadScores(const DeviceField& field);

// Makes position_gradients, zero, where it is absent.
void AllocatePositionGradients(const Device& device, DeviceField& field);

// Parameters and moments. The device must not be using them.
VertexState DownloadState(const DeviceField& field);

}  // namespace tetrec
