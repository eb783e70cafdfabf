// What a renderer refuses at its door: fields that are no fields, and fields that do not fit.
#include "render/field_checks.h"

#include "core/error.h"
#include "mesh/boundary.h"
#include "render/device_field.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {
namespace {

// `owner`: vertex or tet.
void CheckRows(const std::vector<glm::vec4>& rows, size_t owners, const char* owner,
               const char* what) {
  if (rows.size() != owners) {
    throw DataError(fmt::format("{} for {} of {}: one row each is wanted", what, rows.size(),
                                fmt::format("{} {}", owners, owner)));
  }
  for (size_t v = 0; v < owners; ++v) {
    const glm::vec4& row = rows[v];
    for (int i = 0; i < 4; ++i) {
      if (!std::isfinite(row[i])) {
        throw DataError(fmt::format("{} {} has {} that are not finite: ({}, {}, {}, {})", owner, v,
                                    what, row[0], row[1], row[2], row[3]));
      }
    }
  }
}

}  // namespace

void CheckRenderable(const TetMesh& mesh, const VertexState& state) {
  CheckTets(mesh);
  const size_t rows = RowCount(mesh, state.storage);
  const char* owner = state.storage == FieldStorage::kCell ? "tet" : "vertex";
  CheckRows(state.parameters, rows, owner, "parameters (r, g, b, log density)");
  if (state.first_moment.empty() && state.second_moment.empty()) return;
  CheckRows(state.first_moment, rows, owner, "first moments");
  CheckRows(state.second_moment, rows, owner, "second moments");
}

uint64_t FieldBytes(const TetMesh& mesh, FieldStorage storage, bool fixed_point) {
  uint64_t faces = 0;
  for (const glm::uvec4& neighbors : mesh.neighbors) {
    for (int i = 0; i < 4; ++i) faces += neighbors[i] == kNoTet;
  }
  const DeviceFieldBytes bytes = BytesOf(storage, fixed_point);
  return mesh.tets.size() * bytes.of_tet + mesh.positions.size() * bytes.of_vertex +
         faces * bytes.of_face;
}

FreeMemory MeasureFreeMemory(const Device& device) {
  if (device.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) {
    return MeasureFreeHostMemory();
  }
  uint64_t largest = 0;
  for (uint32_t i = 0; i < device.memory.memoryHeapCount; ++i) {
    largest = std::max<uint64_t>(largest, device.memory.memoryHeaps[i].size);
  }
  return {largest, fmt::format("device '{}'", device.properties.deviceName)};
}

void CheckMemory(const TetMesh& mesh, uint64_t needed, const FreeMemory& free) {
  if (needed <= free.bytes) return;
  throw EnvironmentError(
      fmt::format("a field of {} tets and {} vertices needs {} bytes ({} MiB), {} has {} ({} MiB): "
                  "use fewer tets or a device with more memory",
                  mesh.tets.size(), mesh.positions.size(), needed, needed >> 20, free.of,
                  free.bytes, free.bytes >> 20));
}

}  // namespace tetrec
