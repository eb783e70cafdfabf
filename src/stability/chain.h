// The stages from a scene to its held-out views as child processes, and what came of them. A crash
// of a stage is a result like any other.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct ChainRequest {
  std::filesystem::path programs;    // folder with tetrec-optimize and the others
  std::filesystem::path scene;       // folder of the first stage
  std::filesystem::path tetrahedra;  // a start that exists already; empty: the chain makes it
  std::filesystem::path folder;      // to write stages 2 to 4 into
  std::vector<std::string> tetrahedralize, optimize;  // options
  double time_limit_s = 600;                          // of each stage, which is then killed
};

struct ChainResult {
  std::string failed_stage;  // "optimize"; empty if all are done
  int exit_code = 0;         // of that stage: 128 + signal if one ended it, 124 if it was killed
                             // because it took too long
  std::string said;          // its error, or else the last warning of the stages; may be empty
  double seconds = 0;        // of tetrec-optimize
  std::optional<double> psnr, worst_psnr;  // [dB] mean and least of the held-out views
  uint64_t tets = 0, vertices = 0;
  uint64_t degenerate_tets = 0;  // flat or inside out, by the exact predicate
  double min_radius_ratio = 0;   // of the fitted mesh
};

inline constexpr int kTookTooLong = 124;  // the exit code of timeout(1)

// Runs the stages that are not up to date. Throws EnvironmentError if a program is missing.
ChainResult RunChain(const ChainRequest& request);

// The members by name; null stands for what is unknown.
nlohmann::json JsonOf(const ChainResult& result);

}  // namespace tetrec
