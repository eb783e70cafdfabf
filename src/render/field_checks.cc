// What a renderer refuses at its door: invalid fields, and fields that do not fit into memory.
#include "render/field_checks.h"

#include "core/error.h"
#include "mesh/boundary.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {

void CheckRows(std::span<const float> values, const FieldLayout& layout, size_t rows,
               const char* what) {
  const size_t components = size_t(layout.Components());
  const char* owner = RowName(layout.storage);
  if (values.size() != rows * components) {
    throw DataError(fmt::format("{} {}: {} {} have {} components each", values.size(), what, rows,
                                layout.storage == FieldStorage::kCell ? "tets" : "vertices",
                                components));
  }
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw DataError(fmt::format("{} {} has {} that are not finite: {} is {}", owner, i / components,
                                what, layout.ParameterNames()[i % components], values[i]));
  }
}

void CheckRenderable(const TetMesh& mesh, const FieldState& state) {
  CheckTets(mesh);
  CheckLayout(state.layout);
  const size_t rows = RowCount(mesh, state.layout.storage);
  CheckRows(state.parameters, state.layout, rows, "parameters");
  CheckRows(state.first_moment, state.layout, rows, "first moments");
  CheckRows(state.second_moment, state.layout, rows, "second moments");
}

void CheckRateShares(std::span<const float> shares, size_t rows) {
  if (shares.size() != rows) {
    throw DataError(fmt::format("{} rate shares for {} rows", shares.size(), rows));
  }
  for (size_t row = 0; row < rows; ++row) {
    if (shares[row] >= 0.0f && shares[row] <= 1.0f) continue;
    throw DataError(fmt::format("rate share {} is {}, not in [0, 1]", row, shares[row]));
  }
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
