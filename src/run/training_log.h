// metrics.csv: the progress of an optimisation, one row each 2 % of the run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kTrainingLogFile = "metrics.csv";

// One row; the columns have the names and the order of the fields. What was not measured is an
// empty cell.
struct TrainingRow {
  uint64_t iteration = 0;
  double seconds = 0;  // of optimisation
  uint64_t rays = 0;   // so far
  std::optional<double> loss;
  // [dB]. While a run goes on, that of the watched views is of some of their pixels.
  std::optional<double> train_psnr, heldout_psnr;
  uint64_t tets = 0, vertices = 0;
  std::string phase;                        // "optimise", or "end" in the last row
  std::optional<uint64_t> degenerate_tets;  // flat or inside out, where moves may make such
};

// Appends rows to a file; each is complete on disk when Add returns. Throws EnvironmentError naming
// the file.
class TrainingLogWriter {
 public:
  // Resumes a log by cutting it back to its first `keep_bytes`, the length that the checkpoint
  // recorded. For 0, or if the file is shorter than that, it starts again with the header line.
  TrainingLogWriter(std::filesystem::path path, uint64_t keep_bytes);

  void Add(const TrainingRow& row);
  uint64_t bytes() const;  // length of the file

 private:
  std::filesystem::path path_;
};

// Finds the columns by the names in the header line and ignores others; the last may be missing.
// Leaves out a last line that does not end in a newline: the optimiser may still be writing it.
// Throws DataError naming file, line and column.
std::vector<TrainingRow> ReadTrainingLog(const std::filesystem::path& path);

}  // namespace tetrec
