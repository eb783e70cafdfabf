// The radiance field: checks and its file (.tetf).
#include "field/radiance_field.h"

#include "core/error.h"
#include "core/error_context.h"
#include "mesh/tet_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

bool StartsWith(std::span<const uint8_t> bytes, const char (&magic)[9]) {
  return bytes.size() >= 8 && std::memcmp(bytes.data(), magic, 8) == 0;
}

void CheckOther(const AttributeValues& other, size_t count, const char* row) {
  const Attribute& attribute = other.attribute;
  const size_t components = size_t(attribute.components);
  if (other.values.size() != count * components) {
    throw DataError(fmt::format("attribute '{}' has {} values, must have {} for each {}",
                                attribute.name, other.values.size(), components, row));
  }
  for (size_t i = 0; i < other.values.size(); ++i) {
    const float value = other.values[i];
    if (std::isfinite(value) && (value >= 0 || attribute.activation != Activation::kExp)) continue;
    throw DataError(fmt::format("'{}' of {} {} is {}: it must be finite{}", attribute.name, row,
                                i / components, value,
                                attribute.activation == Activation::kExp ? " and 0 or more" : ""));
  }
}

}  // namespace

FieldLayout LayoutOf(const RadianceField& field) {
  FieldLayout layout{.storage = field.storage};
  for (const AttributeValues& other : field.others) layout.attributes.push_back(other.attribute);
  return layout;
}

std::vector<float> ValuesOf(const RadianceField& field) {
  std::vector<float> values;
  values.reserve(field.density.size() * size_t(LayoutOf(field).Components()));
  for (size_t row = 0; row < field.density.size(); ++row) {
    const glm::vec3& color = field.color_srgb[row];
    for (const float value : {color.r, color.g, color.b, field.density[row]}) {
      values.push_back(value);
    }
    for (const AttributeValues& other : field.others) {
      const auto first = other.values.begin() + long(row) * other.attribute.components;
      values.insert(values.end(), first, first + other.attribute.components);
    }
  }
  return values;
}

RadianceField MakeField(TetMesh mesh, const FieldLayout& layout, std::span<const float> values) {
  RadianceField field;
  field.mesh = std::move(mesh);
  field.storage = layout.storage;
  for (size_t i = 2; i < layout.attributes.size(); ++i) {
    field.others.push_back({layout.attributes[i], {}});
  }
  const size_t components = size_t(layout.Components());
  for (size_t at = 0; at + components <= values.size(); at += components) {
    const float* row = &values[at];
    field.color_srgb.emplace_back(row[kColorOffset], row[kColorOffset + 1], row[kColorOffset + 2]);
    field.density.push_back(row[kDensityOffset]);
    const float* value = row + kStandardComponents;
    for (AttributeValues& other : field.others) {
      other.values.insert(other.values.end(), value, value + other.attribute.components);
      value += other.attribute.components;
    }
  }
  return field;
}

void CheckField(const RadianceField& field) {
  CheckLayout(LayoutOf(field));
  const size_t count = RowCount(field);
  const char* row = RowName(field.storage);
  if (field.density.size() != count || field.color_srgb.size() != count) {
    throw DataError(fmt::format("the field has {} {} but {} densities and {} colours", count,
                                field.storage == FieldStorage::kCell ? "tets" : "vertices",
                                field.density.size(), field.color_srgb.size()));
  }
  for (size_t v = 0; v < count; ++v) {
    const float density = field.density[v];
    const glm::vec3& color = field.color_srgb[v];
    // Negative values have a meaning only where density is linear between them.
    const bool has_cells = field.storage == FieldStorage::kCell;
    if (!std::isfinite(density) || (has_cells && density < 0)) {
      throw DataError(fmt::format("the density of {} {} is {}: it must be finite{}", row, v,
                                  density, has_cells ? " and 0 or more" : ""));
    }
    if (!std::isfinite(color.r) || !std::isfinite(color.g) || !std::isfinite(color.b)) {
      throw DataError(fmt::format("the colour of {} {} is not finite: ({}, {}, {})", row, v,
                                  color.r, color.g, color.b));
    }
  }
  for (const AttributeValues& other : field.others) CheckOther(other, count, row);
}

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  ByteWriter head;
  const bool is_standard = field.others.empty();
  if (!is_standard) {
    head.WriteArray<char>({"TETRECF3", 8});
    AppendLayout(head, LayoutOf(field));
  } else {
    head.WriteArray<char>({field.storage == FieldStorage::kCell ? "TETRECF2" : "TETRECF1", 8});
  }
  AppendTetMeshHead(head, field.mesh);
  std::vector<std::span<const uint8_t>> pieces = {head.bytes()};
  for (const auto& array : TetMeshArrays(field.mesh)) pieces.push_back(array);
  if (is_standard) pieces.push_back(BytesOf(field.density));
  pieces.push_back(BytesOf(field.color_srgb));
  if (!is_standard) pieces.push_back(BytesOf(field.density));
  for (const AttributeValues& other : field.others) pieces.push_back(BytesOf(other.values));
  WritePieces(path, pieces);
}

RadianceField ReadField(const std::filesystem::path& path, Orientations expected) {
  return ParseField(ReadBytes(path), path.string(), expected);
}

RadianceField ParseField(std::span<const uint8_t> bytes, const std::string& name,
                         Orientations expected) {
  ByteReader reader(bytes, name);
  RadianceField field;
  if (StartsWith(bytes, "TETRECF3")) {
    ExpectMagic(reader, "TETRECF3", "radiance field");
    const FieldLayout layout = TakeLayout(reader);
    field = MakeField(TakeTetMesh(reader, expected), layout, {});
    const size_t count = RowCount(field);
    field.color_srgb = reader.ReadArray<glm::vec3>(count, "colours");
    field.density = reader.ReadArray<float>(count, "densities");
    for (AttributeValues& other : field.others) {
      other.values = reader.ReadArray<float>(count * uint64_t(other.attribute.components),
                                             other.attribute.name.c_str());
    }
  } else {
    const bool has_cells = StartsWith(bytes, "TETRECF2");
    if (has_cells) field.storage = FieldStorage::kCell;
    if (has_cells) {
      ExpectMagic(reader, "TETRECF2", "radiance field");
    } else {
      ExpectMagic(reader, "TETRECF1", "radiance field");
    }
    field.mesh = TakeTetMesh(reader, expected);
    const size_t count = RowCount(field);
    field.density = reader.ReadArray<float>(count, "densities");
    field.color_srgb = reader.ReadArray<glm::vec3>(count, "colours");
  }
  reader.ExpectEnd();
  NamingFile(name, [&] { CheckField(field); });
  return field;
}

}  // namespace tetrec
