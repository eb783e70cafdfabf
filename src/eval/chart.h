// Speed against accuracy: held-out PSNR over seconds of optimisation, for one or more runs.
#pragma once

#include "eval/metrics_csv.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct RunCurve {
  std::string name;  // the run folder's
  std::filesystem::path metrics_csv;
  std::string protocol;          // "optimize 270x480, device llvmpipe"; empty where unknown
  std::vector<MetricsRow> rows;  // only those with a held-out PSNR
};

struct ChartOptions {
  bool log_x = true;
  std::string title;  // empty: made from the runs
};

// `run` is a run folder (then its 3_field is read) or a field folder itself; unfinished runs are
// fine. Throws DataError where there is no metrics.csv or no held-out PSNR in it.
RunCurve ReadRunCurve(const std::filesystem::path& run);

// Writes chart.svg, chart.png, chart.csv (run, seconds, heldout_psnr, tets, ...) and chart.json
// into `out`. Throws EnvironmentError where gnuplot is missing.
void WriteChart(const std::vector<RunCurve>& runs, const ChartOptions& options,
                const std::filesystem::path& out);

}  // namespace tetrec
