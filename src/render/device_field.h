// A field on the device: mesh, parameters, gradients, the state of Adam.
#pragma once

#include "gpu/buffer.h"
#include "render/renderer.h"

#include <span>

namespace tetrec {

// 32 bytes a tet, 32 a vertex, and 48 more a vertex to learn; the hull as one plane and one
// triangle a boundary face (gpu_types.glsl.h tells the layouts).
struct DeviceField {
  TetMesh mesh;  // the host's copy
  Buffer tets, vertices, hull;
  Buffer parameters, moments, gradients;
  Buffer position_gradients;  // vec4 a vertex: xyz | absolute sum; absent until asked for
  Buffer tet_scores;
  uint32_t vertex_count = 0, tet_count = 0, hull_faces = 0;
};

// Gradients and scores start at zero; so do the moments where `state` has none.
DeviceField UploadField(const Device& device, const TetMesh& mesh, const VertexState& state);

// Makes position_gradients, zero, where it is absent.
void AllocatePositionGradients(const Device& device, DeviceField& field);

// Parameters and moments. The device must not be using them.
VertexState DownloadState(const DeviceField& field);

}  // namespace tetrec
