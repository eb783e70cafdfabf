// growth.json: how the mesh of a run grew, and why no further. Written beside the field, read by
// the report.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kMeshGrowthFile = "growth.json";

enum class GrowthDecision : uint64_t {
  kRefine,      // the mesh got more vertices
  kReturn,      // the run went back to the mesh before the last refinement
  kFineEnough,  // the mesh stays as it is
  kEnd,         // the run ended
  kBudget,      // the mesh stays as it is, because a refined one would exceed the budget
  kMatched,     // the mesh stays as it is, because the pictures are matched
  kCoarsen,     // this coarser mesh took the place of the one before
  kTooCoarse,   // this coarser mesh was tried, and the one before stayed
  kTooFine,     // this finer mesh was tried, and the one before stayed
  kTooLate,     // the mesh stays as it is, because too little of the run is left
};

inline constexpr uint64_t kNotCounted = ~uint64_t{0};

// What was known of a mesh when it was decided about.
struct GrowthStep {
  uint64_t iteration = 0;
  double seconds = 0;                 // of optimisation
  uint64_t vertices = 0, tets = 0;    // of the mesh that was decided about
  uint64_t empty_tets = kNotCounted;  // in which no training ray loses 1 % of its light
  uint64_t peak_rss_bytes = 0;        // until then
  double psnr = 0;                    // of the judging pictures [dB]; 0 if nothing judged
  double gain = 0;                    // since the step before [dB]
  double gain_standard_error = 0;     // over the views [dB]
  GrowthDecision decision = GrowthDecision::kRefine;
  uint64_t degenerate_tets = 0;  // flat or inside out
  bool operator==(const GrowthStep&) const = default;
};

// For people: "refined", "returned to the mesh before: ...".
std::string ReasonOf(const GrowthStep& step);

// {"schema": 1, "steps": [{"iteration", "seconds", "vertices", "tets", "empty_tets",
// "peak_rss_bytes", "psnr", "gain", "gain_standard_error", "degenerate_tets", "decision",
// "reason"}]}; empty_tets is null where they were not counted, psnr and what follows from it where
// nothing judged. Throws DataError naming file and field.
void WriteMeshGrowth(const std::filesystem::path& path, const std::vector<GrowthStep>& steps);
std::vector<GrowthStep> ReadMeshGrowth(const std::filesystem::path& path);
std::vector<GrowthStep> ParseMeshGrowth(const nlohmann::json& value, const std::string& name);

}  // namespace tetrec
