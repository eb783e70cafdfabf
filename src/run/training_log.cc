// Writes and reads metrics.csv.
#include "run/training_log.h"

#include "core/error.h"
#include "core/error_context.h"
#include "core/file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <string_view>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

enum Column : size_t {
  kIteration,
  kSeconds,
  kRays,
  kLoss,
  kTrainPsnr,
  kHeldoutPsnr,
  kTets,
  kVertices,
  kPhase,
  kDegenerateTets,
  kColumnCount
};
constexpr std::array<const char*, kColumnCount> kColumns = {
    "iteration",    "seconds", "rays",     "loss",  "train_psnr",
    "heldout_psnr", "tets",    "vertices", "phase", "degenerate_tets"};
constexpr size_t kMissing = size_t(-1);

std::string CellsOf(const TrainingRow& row) {
  const auto cell = [](const char* format, const std::optional<double>& value) {
    return value ? fmt::format(fmt::runtime(format), *value) : std::string();
  };
  return fmt::format("{},{:.3f},{},{},{},{},{},{},{},{}", row.iteration, row.seconds, row.rays,
                     cell("{:.6g}", row.loss), cell("{:.3f}", row.train_psnr),
                     cell("{:.3f}", row.heldout_psnr), row.tets, row.vertices, row.phase,
                     row.degenerate_tets ? fmt::to_string(*row.degenerate_tets) : std::string());
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (size_t begin = 0;;) {
    const size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

// Where the header line has each of our columns.
std::array<size_t, kColumnCount> PlacesIn(const std::vector<std::string_view>& header,
                                          const fs::path& path) {
  std::array<size_t, kColumnCount> places{};
  for (size_t c = 0; c < kColumnCount; ++c) {
    const auto found = std::find(header.begin(), header.end(), kColumns[c]);
    if (found == header.end() && c == kDegenerateTets) {
      places[c] = kMissing;
      continue;
    }
    if (found == header.end()) {
      throw DataError(
          fmt::format("{}: header line has no column '{}'", path.string(), kColumns[c]));
    }
    places[c] = size_t(found - header.begin());
  }
  return places;
}

// The cells of one line by column, and how to name them in messages.
class Line {
 public:
  Line(std::vector<std::string_view> cells, const std::array<size_t, kColumnCount>& places,
       std::string name)
      : cells_(std::move(cells)), places_(places), name_(std::move(name)) {}

  std::string_view Text(Column column) const {
    return places_[column] == kMissing ? std::string_view() : cells_[places_[column]];
  }
  std::optional<double> Number(Column column) const {
    if (Text(column).empty()) return std::nullopt;
    return Parsed<double>(column, "a number");
  }
  double RequiredNumber(Column column) const { return Parsed<double>(column, "a number"); }
  uint64_t Count(Column column) const { return Parsed<uint64_t>(column, "a whole number"); }
  std::optional<uint64_t> CountOrNothing(Column column) const {
    if (Text(column).empty()) return std::nullopt;
    return Count(column);
  }

 private:
  template <class T>
  T Parsed(Column column, const char* expected) const {
    const std::string_view cell = Text(column);
    T value{};
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size()) {
      throw DataError(
          fmt::format("{}, column {}: '{}' is not {}", name_, kColumns[column], cell, expected));
    }
    return value;
  }

  std::vector<std::string_view> cells_;
  const std::array<size_t, kColumnCount>& places_;
  std::string name_;
};

std::vector<TrainingRow> RowsIn(const fs::path& path) {
  const std::string text = ReadText(path);
  std::vector<std::string_view> lines = Split(text, '\n');
  lines.pop_back();  // empty after the last newline, or a line that was cut off
  if (lines.empty()) throw DataError(path.string() + ": has no header line");

  const std::vector<std::string_view> header = Split(lines[0], ',');
  const std::array<size_t, kColumnCount> places = PlacesIn(header, path);
  std::vector<TrainingRow> rows;
  for (size_t n = 1; n < lines.size(); ++n) {
    std::vector<std::string_view> cells = Split(lines[n], ',');
    if (cells.size() != header.size()) {
      throw DataError(fmt::format("{}: line {} has {} cells, the header has {}", path.string(),
                                  n + 1, cells.size(), header.size()));
    }
    const Line line(std::move(cells), places, fmt::format("{}: line {}", path.string(), n + 1));
    rows.push_back({line.Count(kIteration), line.RequiredNumber(kSeconds), line.Count(kRays),
                    line.Number(kLoss), line.Number(kTrainPsnr), line.Number(kHeldoutPsnr),
                    line.Count(kTets), line.Count(kVertices), std::string(line.Text(kPhase)),
                    line.CountOrNothing(kDegenerateTets)});
  }
  return rows;
}

}  // namespace

TrainingLogWriter::TrainingLogWriter(fs::path path, uint64_t keep_bytes) : path_(std::move(path)) {
  if (keep_bytes > 0 && fs::exists(path_) && fs::file_size(path_) >= keep_bytes) {
    fs::resize_file(path_, keep_bytes);
  } else {
    WriteText(path_, fmt::format("{}\n", fmt::join(kColumns, ",")));
  }
}

void TrainingLogWriter::Add(const TrainingRow& row) {
  TETREC_CHECK(row.phase.find_first_of(",\r\n") == std::string::npos, "a phase is one cell");
  std::ofstream out(path_, std::ios::app | std::ios::binary);
  out << CellsOf(row) << '\n';
  out.flush();
  if (!out) throw EnvironmentError(fmt::format("{}: cannot write (disk full?)", path_.string()));
}

uint64_t TrainingLogWriter::bytes() const { return fs::file_size(path_); }

std::vector<TrainingRow> ReadTrainingLog(const fs::path& path) {
  return Advising("run tetrec-optimize again", [&] { return RowsIn(path); });
}

}  // namespace tetrec
