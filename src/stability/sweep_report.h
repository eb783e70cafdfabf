// The results of a sweep as charts on a page, as JSON and as CSV.
#pragma once

#include "stability/sweep.h"

#include <filesystem>
#include <vector>

namespace tetrec {

// Writes sweep.html, sweep.json, sweep.csv, and in charts/ for each parameter the PSNR, the number
// of degenerate tets and the seconds over its values (.svg, .png), with a red cross where a run
// broke. Throws EnvironmentError if gnuplot is missing, after JSON and CSV have been written.
void WriteSweep(const std::vector<SweepResult>& results, const SweepOptions& options,
                const std::filesystem::path& out);

}  // namespace tetrec
