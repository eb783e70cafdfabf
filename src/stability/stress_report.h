// The results of a stress test as a page, as JSON and as CSV.
#pragma once

#include "stability/stress.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// "20 hold, 1 breaks": what the verdicts come to.
std::string StressSummary(const std::vector<StressResult>& results);

// Writes stress.html, stress.json and stress.csv into `out`.
void WriteStress(const std::vector<StressResult>& results, const StressOptions& options,
                 const std::filesystem::path& out);

}  // namespace tetrec
