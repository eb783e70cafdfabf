// metrics.csv, the optimiser's diary.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct MetricsRow {
  double iteration = 0;
  double seconds = 0;  // of optimisation
  double rays = 0;     // so far
  double loss = 0;
  double train_psnr = 0;               // [dB]
  std::optional<double> heldout_psnr;  // [dB], where it was measured
  double tets = 0, vertices = 0;
  std::string phase;
};

// Columns by name from the header line; iteration, seconds, rays, loss, train_psnr, heldout_psnr,
// tets, vertices and phase must be there, others are ignored. A last line that was cut off is left
// out. Throws DataError naming file, line and column.
std::vector<MetricsRow> ReadMetricsCsv(const std::filesystem::path& path);

}  // namespace tetrec
