// Facts from the manifests of a run: stages, options, seconds, memory, device.
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
  uint64_t PeakRssBytes() const;  // 0 if unknown
  std::string Device() const;     // empty if the stage used none
  std::string Command() const;    // as it was typed; empty if unknown
  std::vector<std::string> Warnings() const;
  nlohmann::json Count(const std::string& name) const;  // null if there is none
  // Hash of the outputs of `stage_before`, as this stage read them; empty if unknown.
  std::string HashOfInput(const std::string& stage_before) const;
};

struct RunFacts {
  std::vector<StageFacts> stages;     // in the order of work
  std::vector<std::string> warnings;  // missing links of the chain

  const StageFacts* Find(const std::string& stage) const;  // nullptr if there is none
  const StageFacts* Scene() const;                         // sfm or import
  double Seconds() const;                                  // of all stages
};

// The held-out views that a run watched, of which its curve is the mean, in words: "4 held-out
// views".
std::string WatchedViewsInWords(const StageFacts& optimize);

// Follows the manifests from `last` back to the first stage. A missing folder ends the chain with a
// warning; `last` itself must exist, and no folder may have been recreated since the next one was
// made from it (DataError): scores by other cameras would be wrong.
RunFacts ReadRunFacts(const std::filesystem::path& last);
// Adds the folder of a branch (the surface).
void AddStage(const std::filesystem::path& folder, RunFacts& facts);

}  // namespace tetrec
