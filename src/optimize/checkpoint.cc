// A run of the optimiser on disk, so that a stopped or killed run goes on where it was.
#include "optimize/checkpoint.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

constexpr std::array<char, 8> kMagic = {'T', 'E', 'T', 'R', 'E', 'C', 'K', '2'};

void CheckFinite(const std::vector<glm::vec4>& rows, const std::string& name, const char* what,
                 const char* row) {
  for (size_t v = 0; v < rows.size(); ++v) {
    for (int i = 0; i < 4; ++i) {
      if (!std::isfinite(rows[v][i])) {
        throw DataError(fmt::format("{}: {} of {} {} is not finite", name, what, row, v));
      }
    }
  }
}

// Adam takes their root.
void CheckNotNegative(const std::vector<glm::vec4>& second_moment, const std::string& name,
                      const char* row) {
  for (size_t v = 0; v < second_moment.size(); ++v) {
    if (glm::any(glm::lessThan(second_moment[v], glm::vec4(0.0f)))) {
      throw DataError(fmt::format("{}: a second moment of {} {} is negative", name, row, v));
    }
  }
}

FieldStorage ReadStorage(ByteReader& reader) {
  const uint32_t storage = reader.Read<uint32_t>("storage");
  if (storage > 1) {
    throw DataError(
        fmt::format("{}: storage {} is neither 0 (vertex) nor 1 (cell)", reader.name(), storage));
  }
  return storage == 1 ? FieldStorage::kCell : FieldStorage::kVertex;
}

}  // namespace

void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  ByteWriter writer;
  writer.Write(kMagic);
  writer.Write(checkpoint.iteration);
  writer.Write(checkpoint.seconds);
  writer.Write(checkpoint.rays);
  writer.Write(checkpoint.rounds);
  writer.Write(checkpoint.metrics_bytes);
  writer.Write(uint64_t(checkpoint.mesh.positions.size()));
  writer.Write(uint64_t(checkpoint.mesh.tets.size()));
  writer.Write(uint32_t(checkpoint.state.storage == FieldStorage::kCell ? 1 : 0));
  writer.WriteArray(std::span<const glm::vec3>(checkpoint.mesh.positions));
  writer.WriteArray(std::span<const glm::uvec4>(checkpoint.mesh.tets));
  writer.WriteArray(std::span<const glm::uvec4>(checkpoint.mesh.neighbors));
  writer.WriteArray(std::span<const glm::vec4>(checkpoint.state.parameters));
  writer.WriteArray(std::span<const glm::vec4>(checkpoint.state.first_moment));
  writer.WriteArray(std::span<const glm::vec4>(checkpoint.state.second_moment));
  WriteBytes(path, writer.bytes());
}

Checkpoint ParseCheckpoint(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  if (reader.Read<std::array<char, 8>>("magic") != kMagic) {
    throw DataError(fmt::format("{}: is no checkpoint of this version of Tetrec", name));
  }
  Checkpoint result;
  result.iteration = reader.Read<uint64_t>("iteration");
  result.seconds = reader.Read<double>("seconds");
  result.rays = reader.Read<uint64_t>("rays");
  result.rounds = reader.Read<uint32_t>("rounds");
  result.metrics_bytes = reader.Read<uint64_t>("metrics bytes");
  const uint64_t vertices = reader.Read<uint64_t>("vertex count");
  const uint64_t tets = reader.Read<uint64_t>("tet count");
  result.state.storage = ReadStorage(reader);
  const uint64_t rows = result.state.storage == FieldStorage::kCell ? tets : vertices;
  result.mesh.positions = reader.ReadArray<glm::vec3>(vertices, "positions");
  result.mesh.tets = reader.ReadArray<glm::uvec4>(tets, "tets");
  result.mesh.neighbors = reader.ReadArray<glm::uvec4>(tets, "neighbours");
  result.state.parameters = reader.ReadArray<glm::vec4>(rows, "parameters");
  result.state.first_moment = reader.ReadArray<glm::vec4>(rows, "first moments");
  result.state.second_moment = reader.ReadArray<glm::vec4>(rows, "second moments");
  reader.ExpectEnd();
  if (!std::isfinite(result.seconds) || result.seconds < 0) {
    throw DataError(fmt::format("{}: seconds {} is no time", name, result.seconds));
  }
  const char* row = RowName(result.state.storage);
  CheckFinite(result.state.parameters, name, "a parameter", row);
  CheckFinite(result.state.first_moment, name, "a first moment", row);
  CheckFinite(result.state.second_moment, name, "a second moment", row);
  CheckNotNegative(result.state.second_moment, name, row);
  CheckTetMesh(result.mesh);
  CheckConvexDomain(result.mesh);
  return result;
}

Checkpoint ReadCheckpoint(const std::filesystem::path& path) {
  return ParseCheckpoint(ReadBytes(path), path.string());
}

}  // namespace tetrec
