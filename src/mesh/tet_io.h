// Tet meshes embedded in other files of this project.
#pragma once

#include "core/file.h"
#include "mesh/tet_mesh.h"

#include <array>
#include <cstdint>
#include <span>

namespace tetrec {

// Appends what precedes the arrays of a .tet file, magic included.
void AppendTetMeshHead(ByteWriter& writer, const TetMesh& mesh);
// The arrays of a .tet file, which belong to the mesh.
std::array<std::span<const uint8_t>, 3> TetMeshArrays(const TetMesh& mesh);

// Reads these contents back and runs CheckTetMesh. Throws DataError that names the reader's file.
TetMesh TakeTetMesh(ByteReader& reader, Orientations expected = Orientations::kPositive);

// Throws DataError unless the next 8 bytes are `magic`; `kind` is the kind of file expected.
void ExpectMagic(ByteReader& reader, const char (&magic)[9], const char* kind);

}  // namespace tetrec
