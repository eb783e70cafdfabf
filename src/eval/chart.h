// Speed against accuracy: held-out PSNR over seconds of optimisation, and size against gain: judged
// PSNR over the tets of a growing mesh, for one or more runs.
#pragma once

#include "run/mesh_growth.h"
#include "run/training_log.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct RunCurve {
  std::string name;  // the run folder's
  std::filesystem::path metrics_csv;
  std::string protocol;            // "4 held-out views, 270x480 px, ..."; empty if unknown
  std::vector<TrainingRow> rows;   // only those with a held-out PSNR
  std::vector<GrowthStep> growth;  // of the mesh; empty until the run has finished
};

struct ChartOptions {
  bool log_x = true;
  std::string title;  // empty: made from the runs
};

// `run` is a run folder (then its 3_field is read) or a field folder itself; unfinished runs are
// fine. Throws DataError if there is no metrics.csv, or no held-out PSNR in it.
RunCurve ReadRunCurve(const std::filesystem::path& run);

// Writes chart.svg, chart.png, chart.csv (run, seconds, heldout_psnr, tets, ...) and chart.json
// into `out`, and growth.svg and growth.png if two meshes of a run were judged. Throws
// EnvironmentError if gnuplot is missing.
void WriteChart(const std::vector<RunCurve>& runs, const ChartOptions& options,
                const std::filesystem::path& out);

// Reads the runs, writes their chart into `out`, and returns the curves.
std::vector<RunCurve> DrawChart(const std::vector<std::filesystem::path>& runs,
                                const ChartOptions& options, const std::filesystem::path& out);

}  // namespace tetrec
