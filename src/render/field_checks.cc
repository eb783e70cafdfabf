// What a renderer refuses at its door: invalid fields, and fields that do not fit into memory.
#include "render/field_checks.h"

#include "core/error.h"
#include "mesh/boundary.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {

namespace {

// `names`: of the values of a row.
void CheckRowsOf(std::span<const float> values, FieldStorage storage, size_t rows,
                 const std::vector<std::string>& names, const char* what) {
  const size_t width = names.size();
  if (values.size() != rows * width) {
    throw DataError(fmt::format("{} {}: {} {} have {} each", values.size(), what, rows,
                                storage == FieldStorage::kCell ? "tets" : "vertices", width));
  }
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw DataError(fmt::format("{} {} has {} that are not finite: {} is {}", RowName(storage),
                                i / width, what, names[i % width], values[i]));
  }
}

void CheckMoments(const FieldState& state, size_t rows) {
  const FieldLayout& layout = state.layout;
  std::vector<std::string> names = layout.ParameterNames();
  names.resize(size_t(FieldLayout::FirstMoments()));
  CheckRowsOf(state.first_moment, layout.storage, rows, names, "first moments");
  for (size_t i = 2; i < layout.attributes.size(); ++i) names.push_back(layout.attributes[i].name);
  CheckRowsOf(state.second_moment, layout.storage, rows, names, "second moments");
}

}  // namespace

void CheckRows(std::span<const float> values, const FieldLayout& layout, size_t rows,
               const char* what) {
  CheckRowsOf(values, layout.storage, rows, layout.ParameterNames(), what);
}

void CheckRenderable(const TetMesh& mesh, const FieldState& state, Orientations expected) {
  CheckTets(mesh, expected);
  CheckLayout(state.layout);
  const size_t rows = RowCount(mesh, state.layout.storage);
  CheckRows(state.parameters, state.layout, rows, "parameters");
  CheckMoments(state, rows);
}

void CheckRowRates(std::span<const RowRates> rates, size_t rows) {
  if (rates.size() != rows) {
    throw DataError(fmt::format("{} rates for {} rows", rates.size(), rows));
  }
  for (size_t row = 0; row < rows; ++row) {
    const RowRates& r = rates[row];
    if (!(r.share >= 0.0f && r.share <= 1.0f)) {
      throw DataError(fmt::format("rate share {} is {}, not in [0, 1]", row, r.share));
    }
    if (!(r.kept_density >= 0.0f)) {
      throw DataError(fmt::format("kept density {} is {}, not 0 or more", row, r.kept_density));
    }
    if (std::isnan(r.least_density)) {
      throw DataError(fmt::format("least density {} is not a number", row));
    }
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
