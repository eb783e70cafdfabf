// A run of the optimiser on disk, so that a stopped or killed run goes on where it was.
#pragma once

#include "mesh/tet_mesh.h"
#include "render/renderer.h"

#include <filesystem>
#include <span>

namespace tetrec {

struct Checkpoint {
  uint64_t iteration = 0;  // steps done
  double seconds = 0;      // of optimisation
  uint64_t rays = 0;
  uint32_t rounds = 0;         // refinements done
  uint64_t metrics_bytes = 0;  // length of metrics.csv then
  TetMesh mesh;
  VertexState state;
};

// Own format, little endian: "TETRECK2", u64 iteration, f64 seconds, u64 rays, u32 rounds,
// u64 metrics bytes, u64 V, u64 T, u32 storage (0 vertex, 1 cell), positions f32 x 3 V, tets and
// neighbours u32 x 4 T each, then parameters, first and second moments f32 x 4 a vertex, or a tet,
// each. Written by rename.
void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);
// Throws DataError where the file is cut off or does not fit together.
Checkpoint ReadCheckpoint(const std::filesystem::path& path);
Checkpoint ParseCheckpoint(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
