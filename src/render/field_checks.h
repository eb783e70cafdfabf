// What a renderer refuses at its door: fields that are no fields, and fields that do not fit.
#pragma once

#include "core/free_memory.h"
#include "gpu/device.h"
#include "render/renderer.h"

namespace tetrec {

// CheckTets of the mesh; every parameter and moment finite, one row a vertex (or no moments).
// Throws DataError that names tet or vertex and value.
void CheckRenderable(const TetMesh& mesh, const VertexState& state);

// Bytes that UploadField and AllocatePositionGradients will take on the device.
uint64_t FieldBytes(const TetMesh& mesh, FieldStorage storage, bool fixed_point);

// Of a software device: what the host can give away without swapping; of others: their largest
// heap.
FreeMemory MeasureFreeMemory(const Device& device);

// Throws EnvironmentError where less is free than `needed`.
void CheckMemory(const TetMesh& mesh, uint64_t needed, const FreeMemory& free);

}  // namespace tetrec
