// Triangle meshes as binary glTF.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"

#include <filesystem>

namespace tetrec {

// Writes glTF 2.0 in one file (.glb): one mesh with vertex colours, or with a texture instead, for
// which `mesh` has texture coordinates. Viewers show it unlit, because the photos' light is in its
// colours. `mesh` has y up, as glTF demands, and at least one triangle; `texture` is RGB.
void WriteTriangleMeshGlb(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const Image& texture = {});

}  // namespace tetrec
