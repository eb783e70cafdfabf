// Meshes by TetGen, a program of its own: it is AGPL, and bad input crashes it.
#pragma once

#include "geometry/bounds3.h"
#include "mesh/tet_mesh.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Fills a box, given as its 12 surface triangles, with quality tets. The surface keeps its 12
// triangles
// (-Y), so tets beside it may exceed max_volume [world unit^3]; the others do not. Files are
// exchanged through `folder`; the seed jitters the inner points that TetGen starts from. Throws
// DataError: box not finite or flat, volume bound not positive, unusable result; EnvironmentError:
// tetgen missing or ended with an error.
TetMesh TetrahedralizeBox(const Bounds3& box, double max_volume, uint64_t seed,
                          const std::filesystem::path& folder);

// Parses what TetGen wrote; tets are turned to positive orientation. Throws DataError naming file
// and line.
TetMesh ParseTetgen(const std::string& node_text, const std::string& ele_text,
                    const std::string& node_name, const std::string& ele_name);

}  // namespace tetrec
