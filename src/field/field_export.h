// Fields in file formats of other programs.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "geometry/rigid3.h"

#include <filesystem>
#include <optional>

namespace tetrec {

// Density and colour of the field in frame b, with density per unit of length of b, and of the tets
// whose four vertices are inside `crop_in_b` only. The mesh has no neighbours.
RadianceField MovedForExport(const RadianceField& field, const Similarity3& b_from_a,
                             const std::optional<Bounds3>& crop_in_b);

// VTK's unstructured grid (VTU, XML with base64): "density" and "color" of points or cells, as the
// field stores them, and "quality" of cells, the radius ratio (1: regular, 0: flat).
void WriteVtu(const std::filesystem::path& path, const RadianceField& field);
// Gmsh's format 2.2, binary, with the same data.
void WriteGmsh(const std::filesystem::path& path, const RadianceField& field);
// MEDIT's text format: the mesh alone.
void WriteMedit(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace tetrec
