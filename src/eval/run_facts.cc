// Reads manifests, following "previous" from one to the next.
#include "eval/run_facts.h"

#include "core/error.h"
#include "core/manifest.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

const std::set<std::string> kStages = {"sfm",    "import",  "tetrahedralize", "optimize",
                                       "render", "surface", "evaluate"};

// Null if the field is missing, as in manifests of older versions.
nlohmann::json Field(const nlohmann::json& object, const std::string& name) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(name);
  return found == object.end() ? nlohmann::json() : *found;
}

StageFacts FactsOf(const std::filesystem::path& folder) {
  StageFacts facts;
  facts.folder = folder;
  facts.manifest = ReadManifest(folder, kStages);
  facts.stage = facts.manifest["stage"].get<std::string>();
  return facts;
}

}  // namespace

double StageFacts::Seconds() const {
  const nlohmann::json total = Field(Field(manifest, "seconds"), "total");
  return total.is_number() ? total.get<double>() : 0;
}

uint64_t StageFacts::PeakRssBytes() const {
  const nlohmann::json bytes = Field(manifest, "peak_rss_bytes");
  return bytes.is_number_unsigned() ? bytes.get<uint64_t>() : 0;
}

std::string StageFacts::Device() const {
  const nlohmann::json device = Field(manifest, "device");
  if (device.is_string()) return device.get<std::string>();
  const nlohmann::json name = Field(device, "name"), driver = Field(device, "driver");
  if (!name.is_string()) return "";
  return name.get<std::string>() + (driver.is_string() ? ", " + driver.get<std::string>() : "");
}

std::string StageFacts::Command() const {
  const nlohmann::json command = Field(manifest, "command");
  return command.is_string() ? command.get<std::string>() : "";
}

std::vector<std::string> StageFacts::Warnings() const {
  std::vector<std::string> warnings;
  const nlohmann::json list = Field(manifest, "warnings");
  if (!list.is_array()) return warnings;
  for (const nlohmann::json& warning : list) {
    if (warning.is_string()) warnings.push_back(warning.get<std::string>());
  }
  return warnings;
}

nlohmann::json StageFacts::Count(const std::string& name) const {
  return Field(Field(manifest, "counts"), name);
}

std::string StageFacts::HashOfInput(const std::string& stage_before) const {
  const nlohmann::json inputs = Field(manifest, "inputs");
  if (!inputs.is_array()) return "";
  for (const nlohmann::json& input : inputs) {
    const nlohmann::json hash = Field(input, "sha256");
    if (Field(input, "stage") == stage_before && hash.is_string()) return hash.get<std::string>();
  }
  return "";
}

const StageFacts* RunFacts::Find(const std::string& stage) const {
  const auto it =
      std::find_if(stages.begin(), stages.end(), [&](const auto& s) { return s.stage == stage; });
  return it == stages.end() ? nullptr : &*it;
}

const StageFacts* RunFacts::Scene() const {
  const StageFacts* sfm = Find("sfm");
  return sfm ? sfm : Find("import");
}

double RunFacts::Seconds() const {
  double seconds = 0;
  for (const StageFacts& stage : stages) seconds += stage.Seconds();
  return seconds;
}

std::string WatchedViewsInWords(const StageFacts& optimize) {
  const nlohmann::json watched = optimize.Count("watched_views");
  if (!watched.is_number_unsigned()) return "some held-out views";
  const auto count = watched.get<size_t>();
  return fmt::format("{} held-out view{}", count, count == 1 ? "" : "s");
}

RunFacts ReadRunFacts(const std::filesystem::path& last) {
  RunFacts facts;
  facts.stages.push_back(FactsOf(last));
  while (facts.stages.size() < size_t{kLongestChain}) {
    const StageFacts& newest = facts.stages.back();
    const std::optional<std::filesystem::path> previous =
        PreviousFolder(newest.folder, newest.manifest);
    if (!previous) break;
    CheckIsMadeFrom(newest.folder, newest.manifest, *previous);
    try {
      facts.stages.push_back(FactsOf(*previous));
    } catch (const DataError& error) {
      facts.warnings.push_back(
          fmt::format("the stages before {} are unknown: {}", newest.stage, error.what()));
      break;
    }
  }
  std::reverse(facts.stages.begin(), facts.stages.end());
  return facts;
}

void AddStage(const std::filesystem::path& folder, RunFacts& facts) {
  facts.stages.push_back(FactsOf(folder));
}

}  // namespace tetrec
