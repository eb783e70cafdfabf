// What a renderer refuses at its door: invalid fields, and fields that do not fit into memory.
#pragma once

#include "core/free_memory.h"
#include "field/field_state.h"

#include <cstdint>
#include <span>

namespace tetrec {

// CheckTets of the mesh, with what is expected of its tets; every parameter and moment finite, one
// row per vertex or tet. Throws DataError that names tet or vertex, component and value.
void CheckRenderable(const TetMesh& mesh, const FieldState& state, Orientations expected);

// One finite value per component and row; `what` names them in the DataError.
void CheckRows(std::span<const float> values, const FieldLayout& layout, size_t rows,
               const char* what);

// One share in [0, 1] per row. Throws DataError.
void CheckRateShares(std::span<const float> shares, size_t rows);

// Throws EnvironmentError if less is free than `needed`.
void CheckMemory(const TetMesh& mesh, uint64_t needed, const FreeMemory& free);

}  // namespace tetrec
