// What a benchmark measured, as CSV, as a table and as charts.
#pragma once

#include "bench/bench_run.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Markdown: what the columns are, then a row a case, as wide as its widest cells.
std::string BenchTable(const BenchResult& result);

// Writes bench.csv, table.md, and accuracy and scaling (.svg, .png) into `out`; no accuracy where
// nothing errs. Throws
// EnvironmentError where gnuplot is missing; table and CSV are written before.
void WriteBench(const BenchResult& result, const std::filesystem::path& out);

}  // namespace tetrec
