// Fields in file formats of other programs.
#include "field/field_export.h"

#include "core/base64.h"
#include "core/file.h"

#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace tetrec {
namespace {

static_assert(std::endian::native == std::endian::little, "both binary formats say so");

std::vector<float> RadiusRatios(const TetMesh& mesh) {
  std::vector<float> ratios;
  ratios.reserve(mesh.tets.size());
  for (const glm::uvec4& tet : mesh.tets) ratios.push_back(float(RadiusRatio(mesh, tet)));
  return ratios;
}

// VTU: a DataArray whose text is the base64 of its size in bytes and its values.
template <class T>
void AppendDataArray(std::string& xml, const char* type, const char* name, int components,
                     std::span<const T> values) {
  ByteWriter bytes;
  bytes.Write(uint64_t{values.size_bytes()});
  bytes.WriteArray(values);
  fmt::format_to(std::back_inserter(xml), "<DataArray type=\"{}\" Name=\"{}\"", type, name);
  // Some readers make rows of one number of values that are said to have one component.
  if (components > 1) {
    fmt::format_to(std::back_inserter(xml), " NumberOfComponents=\"{}\"", components);
  }
  xml += " format=\"binary\">";
  xml += Base64(bytes.bytes());
  xml += "</DataArray>\n";
}

void AppendCells(std::string& xml, const std::vector<glm::uvec4>& tets) {
  constexpr uint8_t kVtkTetra = 10;
  std::vector<int32_t> ids;
  std::vector<int64_t> ends;
  for (const glm::uvec4& tet : tets) {
    for (int i = 0; i < 4; ++i) ids.push_back(int32_t(tet[i]));
    ends.push_back(int64_t(ids.size()));
  }
  const std::vector<uint8_t> types(tets.size(), kVtkTetra);
  xml += "<Cells>\n";
  AppendDataArray<int32_t>(xml, "Int32", "connectivity", 1, ids);
  AppendDataArray<int64_t>(xml, "Int64", "offsets", 1, ends);
  AppendDataArray<uint8_t>(xml, "UInt8", "types", 1, types);
  xml += "</Cells>\n";
}

void AppendDensityAndColor(std::string& xml, const RadianceField& field) {
  AppendDataArray<float>(xml, "Float32", "density", 1, field.density);
  AppendDataArray<glm::vec3>(xml, "Float32", "color", 3, field.color_srgb);
}

void AppendText(ByteWriter& out, const std::string& text) {
  out.WriteArray(std::span<const char>(text));
}

// Gmsh: a section of one value, or of three, per vertex ("NodeData") or tet ("ElementData").
void AppendGmshData(ByteWriter& out, const char* section, const char* name, int components,
                    size_t rows, const float* values) {
  AppendText(
      out, fmt::format("${}\n1\n\"{}\"\n1\n0.0\n3\n0\n{}\n{}\n", section, name, components, rows));
  for (size_t row = 0; row < rows; ++row) {
    out.Write(int32_t(row + 1));
    for (int c = 0; c < components; ++c) out.Write(double(values[row * size_t(components) + c]));
  }
  AppendText(out, fmt::format("\n$End{}\n", section));
}

}  // namespace

RadianceField MovedForExport(const RadianceField& field, const Similarity3& b_from_a,
                             const std::optional<Bounds3>& crop_in_b) {
  RadianceField moved;
  moved.storage = field.storage;
  const auto add_row = [&](size_t row) {
    moved.density.push_back(float(field.density[row] / b_from_a.scale));
    moved.color_srgb.push_back(field.color_srgb[row]);
  };
  constexpr uint32_t kNone = 0xFFFFFFFFu;
  std::vector<glm::vec3> positions;
  std::vector<uint8_t> is_inside;
  for (const glm::vec3& p : field.mesh.positions) {
    const glm::dvec3 in_b = b_from_a * glm::dvec3(p);
    positions.emplace_back(in_b);
    is_inside.push_back(!crop_in_b || crop_in_b->Contains(in_b));
  }
  std::vector<uint32_t> new_vertex(positions.size(), kNone);
  for (size_t t = 0; t < field.mesh.tets.size(); ++t) {
    glm::uvec4 tet = field.mesh.tets[t];
    if (!is_inside[tet[0]] || !is_inside[tet[1]] || !is_inside[tet[2]] || !is_inside[tet[3]]) {
      continue;
    }
    for (int i = 0; i < 4; ++i) {
      uint32_t& id = new_vertex[tet[i]];
      if (id == kNone) {
        id = uint32_t(moved.mesh.positions.size());
        moved.mesh.positions.push_back(positions[tet[i]]);
        if (field.storage == FieldStorage::kVertex) add_row(tet[i]);
      }
      tet[i] = id;
    }
    moved.mesh.tets.push_back(tet);
    if (field.storage == FieldStorage::kCell) add_row(t);
  }
  return moved;
}

void WriteVtu(const std::filesystem::path& path, const RadianceField& field) {
  const TetMesh& mesh = field.mesh;
  std::string xml = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
      mesh.positions.size(), mesh.tets.size());
  AppendDataArray<glm::vec3>(xml, "Float32", "Points", 3, mesh.positions);
  xml += "</Points>\n";
  AppendCells(xml, mesh.tets);
  xml += "<PointData>\n";
  if (field.storage == FieldStorage::kVertex) AppendDensityAndColor(xml, field);
  xml += "</PointData>\n<CellData>\n";
  if (field.storage == FieldStorage::kCell) AppendDensityAndColor(xml, field);
  AppendDataArray<float>(xml, "Float32", "quality", 1, RadiusRatios(mesh));
  xml += "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  WriteText(path, xml);
}

void WriteGmsh(const std::filesystem::path& path, const RadianceField& field) {
  const TetMesh& mesh = field.mesh;
  ByteWriter out;
  AppendText(out, "$MeshFormat\n2.2 1 8\n");  // version, binary, bytes of a real number
  out.Write(int32_t{1});                      // by which readers recognise the byte order
  AppendText(out, fmt::format("\n$EndMeshFormat\n$Nodes\n{}\n", mesh.positions.size()));
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    out.Write(int32_t(v + 1));
    out.Write(glm::dvec3(mesh.positions[v]));
  }
  AppendText(out, fmt::format("\n$EndNodes\n$Elements\n{}\n", mesh.tets.size()));
  constexpr int32_t kTetrahedron = 4, kTags = 2, kEntity = 1;
  for (const int32_t value : {kTetrahedron, int32_t(mesh.tets.size()), kTags}) out.Write(value);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const int32_t value : {int32_t(t + 1), kEntity, kEntity}) out.Write(value);
    out.Write(glm::ivec4(mesh.tets[t]) + 1);
  }
  AppendText(out, "\n$EndElements\n");
  const char* section = field.storage == FieldStorage::kVertex ? "NodeData" : "ElementData";
  AppendGmshData(out, section, "density", 1, field.density.size(), field.density.data());
  AppendGmshData(out, section, "color", 3, field.color_srgb.size(),
                 field.color_srgb.empty() ? nullptr : &field.color_srgb[0].x);
  const std::vector<float> quality = RadiusRatios(mesh);
  AppendGmshData(out, "ElementData", "quality", 1, quality.size(), quality.data());
  WriteBytes(path, out.bytes());
}

void WriteMedit(const std::filesystem::path& path, const TetMesh& mesh) {
  std::string text =
      fmt::format("MeshVersionFormatted 2\nDimension 3\n\nVertices\n{}\n", mesh.positions.size());
  const auto out = std::back_inserter(text);
  for (const glm::vec3& p : mesh.positions) {
    fmt::format_to(out, "{:.9g} {:.9g} {:.9g} 0\n", p.x, p.y, p.z);
  }
  fmt::format_to(out, "\nTetrahedra\n{}\n", mesh.tets.size());
  for (const glm::uvec4& tet : mesh.tets) {
    fmt::format_to(out, "{} {} {} {} 0\n", tet[0] + 1, tet[1] + 1, tet[2] + 1, tet[3] + 1);
  }
  text += "\nEnd\n";
  WriteText(path, text);
}

}  // namespace tetrec
