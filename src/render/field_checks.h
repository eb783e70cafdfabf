// What a renderer refuses at its door: invalid fields, and fields that do not fit into memory.
#pragma once

#include "core/free_memory.h"
#include "field/field_state.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <span>

namespace tetrec {

// CheckTets of the mesh, with what is expected of its tets; every parameter and moment finite, one
// row per vertex or tet. Throws DataError that names tet or vertex, component and value.
void CheckRenderable(const TetMesh& mesh, const FieldState& state, Orientations expected);

// One finite value per component and row; `what` names them in the DataError.
void CheckRows(std::span<const float> values, const FieldLayout& layout, size_t rows,
               const char* what);

// For each row a share in [0, 1], and a kept density of 0 or more. Throws DataError.
void CheckRowRates(std::span<const RowRates> rates, size_t rows);

// Throws EnvironmentError if less is free than `needed`.
void CheckMemory(const TetMesh& mesh, uint64_t needed, const FreeMemory& free);

}  // namespace tetrec
