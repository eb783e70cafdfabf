// Triangle meshes with vertex colours.
#pragma once

#include "geometry/rigid3.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

struct TriangleMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::array<uint8_t, 3>> colors_srgb;  // empty, or one per vertex
  std::vector<glm::uvec3> triangles;                // counter-clockwise seen from outside
};

// Reads PLY (any scalar types; faces are triangulated as fans), writes binary PLY, OBJ and binary
// STL. PLY and OBJ have vertex colours, which OBJ only has by a common extension; STL has none.
TriangleMesh ReadTriangleMesh(const std::filesystem::path& path);
void WriteTriangleMeshPly(const std::filesystem::path& path, const TriangleMesh& mesh);
void WriteTriangleMeshObj(const std::filesystem::path& path, const TriangleMesh& mesh);
void WriteTriangleMeshStl(const std::filesystem::path& path, const TriangleMesh& mesh);

// The mesh moved from frame a to frame b.
TriangleMesh Transformed(TriangleMesh mesh, const Similarity3& b_from_a);

}  // namespace tetrec
