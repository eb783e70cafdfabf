// Meshes by TetGen, run as a separate program because it is AGPL and bad input crashes it.
#pragma once

#include "geometry/bounds3.h"
#include "mesh/tet_mesh.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Fills a box with tets of good quality. The surface keeps its 12 triangles (-Y), so tets beside it
// may exceed max_volume [world unit^3]; the others do not. Files are exchanged through `folder`;
// the seed jitters the inner points that TetGen starts from. Throws DataError if the box is flat or
// not finite, the volume bound is not positive or the result is unusable, EnvironmentError if
// tetgen is missing or fails.
TetMesh TetrahedralizeBox(const Bounds3& box, double max_volume, uint64_t seed,
                          const std::filesystem::path& folder);

// Parses TetGen's output and gives every tet positive orientation. Throws DataError that names file
// and line.
TetMesh ParseTetgen(const std::string& node_text, const std::string& ele_text,
                    const std::string& node_name, const std::string& ele_name);

}  // namespace tetrec
