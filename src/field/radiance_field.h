// The radiance field: density and colour on a tet mesh.
#pragma once

#include "core/words.h"
#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

enum class FieldStorage {
  kVertex,  // a row of attributes a vertex, linear inside each tet
  kCell,    // a row a tet, constant inside
};
template <>
inline constexpr auto kWords<FieldStorage> = std::to_array<Word<FieldStorage>>(
    {{FieldStorage::kVertex, "vertex"}, {FieldStorage::kCell, "cell"}});

// "vertex" or "tet": what has the rows.
const char* RowName(FieldStorage storage);

struct RadianceField {
  TetMesh mesh;
  std::vector<float> density;         // (rows) sigma >= 0 [1 / world unit]
  std::vector<glm::vec3> color_srgb;  // (rows) display sRGB, may leave [0, 1] a little
  FieldStorage storage = FieldStorage::kVertex;
};

// Rows of attributes that a mesh has.
inline size_t RowCount(const TetMesh& mesh, FieldStorage storage) {
  return storage == FieldStorage::kCell ? mesh.tets.size() : mesh.positions.size();
}
inline size_t RowCount(const RadianceField& field) { return RowCount(field.mesh, field.storage); }

// Throws DataError naming the first offence: sizes, negative or non-finite values.
void CheckField(const RadianceField& field);

// Own format, little endian: "TETRECF1", the mesh as in WriteTetMesh, density f32 x V, colour f32 x
// 3 V. Attributes of cells: "TETRECF2", density f32 x T, colour f32 x 3 T.
void WriteField(const std::filesystem::path& path, const RadianceField& field);
RadianceField ReadField(const std::filesystem::path& path);
RadianceField ParseField(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
