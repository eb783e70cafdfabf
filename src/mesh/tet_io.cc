// The tet mesh file (.tet).
#include "mesh/tet_io.h"

#include "core/error.h"
#include "core/error_context.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>

namespace tetrec {

static_assert(std::endian::native == std::endian::little,
              "all formats of this project are little endian");
static_assert(sizeof(glm::vec3) == 12 && sizeof(glm::uvec4) == 16);

void ExpectMagic(ByteReader& reader, const char (&magic)[9], const char* kind) {
  const auto found = reader.Read<std::array<char, 8>>("the magic");
  if (std::memcmp(found.data(), magic, 8) == 0) return;
  const bool other_version = std::memcmp(found.data(), magic, 7) == 0;
  throw DataError(
      other_version
          ? fmt::format("{}: is a {} of format version '{}', this program reads '{}'",
                        reader.name(), kind, found[7], magic[7])
          : fmt::format("{}: is not a {} (it does not start with {})", reader.name(), kind, magic));
}

void AppendTetMeshHead(ByteWriter& writer, const TetMesh& mesh) {
  writer.WriteArray<char>({"TETRECM1", 8});
  writer.Write(uint64_t{mesh.positions.size()});
  writer.Write(uint64_t{mesh.tets.size()});
}

std::array<std::span<const uint8_t>, 3> TetMeshArrays(const TetMesh& mesh) {
  return {BytesOf(mesh.positions), BytesOf(mesh.tets), BytesOf(mesh.neighbors)};
}

TetMesh TakeTetMesh(ByteReader& reader, Orientations expected) {
  ExpectMagic(reader, "TETRECM1", "tet mesh");
  const auto vertex_count = reader.Read<uint64_t>("the number of vertices");
  const auto tet_count = reader.Read<uint64_t>("the number of tets");
  TetMesh mesh;
  mesh.positions = reader.ReadArray<glm::vec3>(vertex_count, "positions");
  mesh.tets = reader.ReadArray<glm::uvec4>(tet_count, "tets");
  mesh.neighbors = reader.ReadArray<glm::uvec4>(tet_count, "neighbours");
  NamingFile(reader.name(), [&] { CheckTetMesh(mesh, expected); });
  return mesh;
}

void WriteTetMesh(const std::filesystem::path& path, const TetMesh& mesh) {
  ByteWriter head;
  AppendTetMeshHead(head, mesh);
  const auto [positions, tets, neighbors] = TetMeshArrays(mesh);
  WritePieces(path, std::vector{std::span(head.bytes()), positions, tets, neighbors});
}

TetMesh ReadTetMesh(const std::filesystem::path& path) {
  return ParseTetMesh(ReadBytes(path), path.string());
}

TetMesh ParseTetMesh(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  TetMesh mesh = TakeTetMesh(reader);
  reader.ExpectEnd();
  return mesh;
}

}  // namespace tetrec
