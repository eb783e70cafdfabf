// The tet mesh inside other files of ours.
#pragma once

#include "core/file.h"
#include "mesh/tet_mesh.h"

namespace tetrec {

// Appends what WriteTetMesh writes, magic included.
void AppendTetMesh(ByteWriter& writer, const TetMesh& mesh);

// Reads it back and runs CheckTetMesh. Throws DataError naming the reader's file.
TetMesh TakeTetMesh(ByteReader& reader);

// Throws DataError unless the next 8 bytes are `magic`; `kind` is what the file should have been.
void ExpectMagic(ByteReader& reader, const char (&magic)[9], const char* kind);

}  // namespace tetrec
