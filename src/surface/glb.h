// Triangle meshes as binary glTF.
#pragma once

#include "mesh/triangle_mesh.h"

#include <filesystem>

namespace tetrec {

// Writes glTF 2.0 in one file (.glb): one mesh with vertex colours, which viewers show unlit,
// because the photos' light is in them. `mesh` has y up, as glTF demands, and at least one
// triangle.
void WriteTriangleMeshGlb(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace tetrec
