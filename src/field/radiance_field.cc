// The radiance field: checks and its file (.tetf).
#include "field/radiance_field.h"

#include "core/error.h"
#include "mesh/tet_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {

namespace {

constexpr std::array<char, 8> kCellMagic = {'T', 'E', 'T', 'R', 'E', 'C', 'F', '2'};

}  // namespace

const char* RowName(FieldStorage storage) {
  return storage == FieldStorage::kCell ? "tet" : "vertex";
}

void CheckField(const RadianceField& field) {
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
    if (!std::isfinite(density) || density < 0) {
      throw DataError(fmt::format("the density of {} {} is {}: it must be finite and 0 or more",
                                  row, v, density));
    }
    if (!std::isfinite(color.r) || !std::isfinite(color.g) || !std::isfinite(color.b)) {
      throw DataError(fmt::format("the colour of {} {} is not finite: ({}, {}, {})", row, v,
                                  color.r, color.g, color.b));
    }
  }
}

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  ByteWriter writer;
  if (field.storage == FieldStorage::kCell) {
    writer.Write(kCellMagic);
  } else {
    writer.WriteArray<char>({"TETRECF1", 8});
  }
  AppendTetMesh(writer, field.mesh);
  writer.WriteArray<float>(field.density);
  writer.WriteArray<glm::vec3>(field.color_srgb);
  WriteBytes(path, writer.bytes());
}

RadianceField ReadField(const std::filesystem::path& path) {
  return ParseField(ReadBytes(path), path.string());
}

RadianceField ParseField(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  RadianceField field;
  if (bytes.size() >= 8 && std::equal(kCellMagic.begin(), kCellMagic.end(), bytes.begin())) {
    reader.Read<std::array<char, 8>>("the magic");
    field.storage = FieldStorage::kCell;
  } else {
    ExpectMagic(reader, "TETRECF1", "radiance field");
  }
  field.mesh = TakeTetMesh(reader);
  const size_t count = RowCount(field);
  field.density = reader.ReadArray<float>(count, "densities");
  field.color_srgb = reader.ReadArray<glm::vec3>(count, "colours");
  reader.ExpectEnd();
  try {
    CheckField(field);
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", name, error.what()));
  }
  return field;
}

}  // namespace tetrec
