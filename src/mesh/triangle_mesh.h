// Triangle meshes with vertex colours and texture coordinates.
#pragma once

#include "geometry/rigid3.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct TriangleMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::array<uint8_t, 3>> colors_srgb;  // empty, or one per vertex
  std::vector<glm::uvec3> triangles;                // counter-clockwise seen from outside
  // Empty, or for the corners of each triangle their place in a texture: from 0 to 1, to the right
  // and up.
  std::vector<std::array<glm::vec2, 3>> corner_coordinates = {};
};

// Reads PLY (any scalar types; faces are triangulated as fans), writes binary PLY, OBJ and binary
// STL. PLY and OBJ have vertex colours, which OBJ only has by a common extension; STL has none.
// Texture coordinates are written if there are any. In PLY they are those of faces ("texcoord") as
// MeshLab has them, read if all faces have finite ones, and `texture_file` becomes the comment
// "TextureFile". An OBJ names `material_file`, and has no vertex colours beside a texture, because
// some programs would multiply them.
TriangleMesh ReadTriangleMesh(const std::filesystem::path& path);
void WriteTriangleMeshPly(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const std::string& texture_file = {});
void WriteTriangleMeshObj(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const std::string& material_file = {});
void WriteTriangleMeshStl(const std::filesystem::path& path, const TriangleMesh& mesh);

// The material that such an OBJ uses: matt, with a texture.
void WriteTextureMaterial(const std::filesystem::path& path, const std::string& texture_file);

// The mesh moved from frame a to frame b.
TriangleMesh Transformed(TriangleMesh mesh, const Similarity3& b_from_a);

// Vertices and triangles of `a`, then those of `b`, without texture coordinates.
TriangleMesh Joined(TriangleMesh a, const TriangleMesh& b);

}  // namespace tetrec
