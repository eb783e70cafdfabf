// The march renderer's kernels and how the mesh and the cameras lie in device memory.
#pragma once

#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/program.h"
#include "render/renderer.h"
#include "shared/gpu_types.glsl.h"

#include <memory>

namespace tetrec {

struct MarchPrograms {
  Program forward, forward_counting, backward, score, loss, adam;
};
MarchPrograms CreateMarchPrograms(const Device& device);

// 32 bytes a tet, 32 a vertex; the hull as one plane and one triangle a boundary face.
struct MarchMesh {
  Buffer tets, vertices, hull;
  uint32_t vertex_count = 0, tet_count = 0, hull_faces = 0;
};
MarchMesh UploadMesh(const Device& device, const TetMesh& mesh,
                     std::span<const glm::vec4> parameters);

// `grid` rays a pixel side; `start_tet` as FindTet gives it.
gpu_types::GpuView MakeGpuView(const RenderView& view, int grid, uint32_t first_pixel,
                               uint32_t start_tet);

}  // namespace tetrec
