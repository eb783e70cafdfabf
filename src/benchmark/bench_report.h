// Results of tetrec-bench as CSV, as a table and as charts.
#pragma once

#include "benchmark/bench_run.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Markdown: an explanation of the columns, then one row per case, in columns of equal width.
std::string BenchTable(const BenchResult& result);

// Writes bench.csv, table.md, and the charts accuracy and scaling (.svg, .png) into `out`; there is
// no accuracy chart if nothing has an error. Throws EnvironmentError if gnuplot is missing, and
// Interrupted after a request to stop, both after table and CSV have been written.
void WriteBench(const BenchResult& result, const std::filesystem::path& out);

}  // namespace tetrec
