// The radiance field: density, colour and further attributes on a tet mesh, and its file (.tetf).
#pragma once

#include "field/layout.h"
#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// An attribute beside density and colour, which renderers that do not know it ignore.
struct AttributeValues {
  Attribute attribute;
  std::vector<float> values;  // rows x components
};

// Values of density at vertices may be negative: density is the positive part of the value, which
// is linear inside a tet (shared/segment_cut.glsl.h). Those of cells are 0 or more.
struct RadianceField {
  TetMesh mesh;
  std::vector<float> density;         // (rows) sigma [1 / world unit]
  std::vector<glm::vec3> color_srgb;  // (rows) display sRGB, may leave [0, 1] a little
  FieldStorage storage = FieldStorage::kVertex;
  std::vector<AttributeValues> others = {};
};

// Rows of attributes that a mesh has.
inline size_t RowCount(const TetMesh& mesh, FieldStorage storage) {
  return storage == FieldStorage::kCell ? mesh.tets.size() : mesh.positions.size();
}
inline size_t RowCount(const RadianceField& field) { return RowCount(field.mesh, field.storage); }

FieldLayout LayoutOf(const RadianceField& field);

// Values (not parameters) row by row in the order of the layout: rows x Components().
std::vector<float> ValuesOf(const RadianceField& field);
// The field that has them.
RadianceField MakeField(TetMesh mesh, const FieldLayout& layout, std::span<const float> values);

// Throws DataError naming the first offence: layout, sizes, non-finite values, negative ones of
// cells.
void CheckField(const RadianceField& field);

// Own format, little endian. A field of density and colour alone: "TETRECF1", the mesh as in
// WriteTetMesh, density f32 x V, colour f32 x 3 V; on cells: "TETRECF2", density f32 x T, colour
// f32 x 3 T. Any other: "TETRECF3", its layout (AppendLayout), the mesh, and each attribute of the
// layout in turn, f32 x rows x components.
void WriteField(const std::filesystem::path& path, const RadianceField& field);
RadianceField ReadField(const std::filesystem::path& path,
                        Orientations expected = Orientations::kPositive);
RadianceField ParseField(std::span<const uint8_t> bytes, const std::string& name,
                         Orientations expected = Orientations::kPositive);

}  // namespace tetrec
