// What the manifests of a run tell: stages, options, seconds, memory, device.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct StageFacts {
  std::string stage;  // "optimize"
  std::filesystem::path folder;
  nlohmann::json manifest;

  double Seconds() const;         // of the whole stage
  uint64_t PeakRssBytes() const;  // 0 where unknown
  std::string Device() const;     // empty where the stage used none
  std::string Command() const;    // as it was typed; empty where unknown
  std::vector<std::string> Warnings() const;
  nlohmann::json Count(const std::string& name) const;  // null where there is none
};

struct RunFacts {
  std::vector<StageFacts> stages;     // in the order of work
  std::vector<std::string> warnings;  // links of the chain that are gone

  const StageFacts* Find(const std::string& stage) const;  // nullptr where there is none
  const StageFacts* Scene() const;                         // sfm or import
};

// Follows the manifests from `last` back to the first stage. A folder that is gone ends the chain
// with a warning; `last` itself must be there (DataError).
RunFacts ReadRunFacts(const std::filesystem::path& last);
// Adds the folder of a branch (the surface).
void AddStage(const std::filesystem::path& folder, RunFacts& facts);

}  // namespace tetrec
