// Parses metrics.csv.
#include "eval/metrics_csv.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

namespace tetrec {
namespace {

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (size_t begin = 0;;) {
    const size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

// The columns that are read, in the order of their use below.
constexpr const char* kColumns[] = {"iteration",    "seconds", "rays",     "loss", "train_psnr",
                                    "heldout_psnr", "tets",    "vertices", "phase"};
constexpr size_t kColumnCount = std::size(kColumns);

}  // namespace

std::vector<MetricsRow> ReadMetricsCsv(const std::filesystem::path& path) {
  const std::string text = ReadText(path);
  std::vector<std::string_view> lines = Split(text, '\n');
  lines.pop_back();  // empty behind the last newline, or cut off
  if (lines.empty()) throw DataError(path.string() + ": has no header line");

  const std::vector<std::string_view> header = Split(lines[0], ',');
  size_t place[kColumnCount];
  for (size_t c = 0; c < kColumnCount; ++c) {
    const auto it = std::find(header.begin(), header.end(), kColumns[c]);
    if (it == header.end()) {
      throw DataError(
          fmt::format("{}: header line has no column '{}'", path.string(), kColumns[c]));
    }
    place[c] = size_t(it - header.begin());
  }

  std::vector<MetricsRow> rows;
  for (size_t n = 1; n < lines.size(); ++n) {
    const std::vector<std::string_view> cells = Split(lines[n], ',');
    if (cells.size() != header.size()) {
      throw DataError(fmt::format("{}: line {} has {} cells, the header has {}", path.string(),
                                  n + 1, cells.size(), header.size()));
    }
    const auto optional_number = [&](size_t column) -> std::optional<double> {
      const std::string_view cell = cells[place[column]];
      if (cell.empty()) return std::nullopt;
      double value = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc() || end != cell.data() + cell.size()) {
        throw DataError(fmt::format("{}: line {}, column {}: '{}' is no number", path.string(),
                                    n + 1, kColumns[column], cell));
      }
      return value;
    };
    const auto number = [&](size_t column) {
      return optional_number(column).value_or(std::numeric_limits<double>::quiet_NaN());
    };
    rows.push_back({number(0), number(1), number(2), number(3), number(4), optional_number(5),
                    number(6), number(7), std::string(cells[place[8]])});
  }
  return rows;
}

}  // namespace tetrec
