// Writing, reading and following manifests.
#include "core/manifest.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/process_memory.h"
#include "core/stage_folder.h"
#include "core/stage_input.h"
#include "core/version.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kSchema = 1;

std::string ProgramsOf(const std::set<std::string>& stages) {
  std::vector<std::string> names;
  for (const std::string& stage : stages) names.push_back(ProgramOf(stage));
  return fmt::format("{}", fmt::join(names, " or "));
}

std::string NowUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

// The first input that is a stage is the one before in the chain.
json PreviousOf(const json& inputs) {
  for (const json& input : inputs) {
    if (input["kind"] == "stage") return input["path"];
  }
  return nullptr;
}

std::string StateAndErrorInWords(const json& status) {
  const std::string state = StateInWords(status), error = TextOrEmpty(status, "error");
  return state + (error.empty() ? "" : ": " + error);
}

// False if the stage before has another result than the one that `manifest` records of its input.
// Null and manifests without a record pass: others report them.
bool IsMadeFrom(const json& manifest, const json& previous) {
  const auto inputs = manifest.find("inputs");
  if (previous.is_null() || inputs == manifest.end() || !inputs->is_array()) return true;
  const std::string hash = HashOfResult(previous);
  // Manifests of earlier versions, which have no such field, record the hash of outputs alone.
  const std::string earlier_hash =
      manifest.contains("degraded") ? hash : HashOfJson(previous.value("outputs", json::array()));
  return std::ranges::all_of(*inputs, [&](const json& input) {
    const std::string recorded = TextOrEmpty(input, "sha256");
    return TextOrEmpty(input, "stage") != TextOrEmpty(previous, "stage") || recorded.empty() ||
           recorded == hash || recorded == earlier_hash;
  });
}

}  // namespace

std::string ProgramOf(const std::string& stage) { return "tetrec-" + stage; }

std::string TextOrEmpty(const json& object, const char* field) {
  if (!object.is_object()) return "";
  const auto found = object.find(field);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

void WriteManifest(const fs::path& folder, const ManifestFacts& facts) {
  const json manifest = {{"schema", kSchema},
                         {"stage", facts.stage},
                         {"version", facts.version},
                         {"program_version", ProgramVersion()},
                         {"git", GitRevision()},
                         {"key", facts.key},
                         {"command", facts.command},
                         {"options", facts.options},
                         {"seed", facts.options.contains("seed") ? facts.options["seed"] : json()},
                         {"inputs", facts.inputs},
                         {"previous", PreviousOf(facts.inputs)},
                         {"outputs", facts.outputs},
                         {"device", facts.device},
                         {"counts", facts.counts},
                         {"notes", facts.notes},
                         {"warnings", facts.warnings},
                         {"degraded", facts.degraded},
                         {"seconds", facts.seconds},
                         {"resumed", facts.resumed},
                         {"peak_rss_bytes", PeakRssBytes()},
                         {"finished", NowUtc()}};
  WriteJson(folder / kManifestFile, manifest);
}

json StatusOfNewRun(const std::string& stage, const std::string& key, const json& options,
                    const std::string& command) {
  return {{"schema", kSchema},       {"stage", stage},
          {"status", "running"},     {"key", key},
          {"options", options},      {"pid", getpid()},
          {"started", NowUtc()},     {"error", nullptr},
          {"own", json::array()},    {"scratch", json::array()},
          {"caches", json::array()}, {"command", command}};
}

json ReadManifest(const fs::path& folder, const std::set<std::string>& stages) {
  const std::string name = folder.string(), programs = ProgramsOf(stages);
  std::error_code error;
  if (fs::is_regular_file(folder, error)) {
    const fs::path parent = fs::absolute(folder).parent_path();
    const json written = ReadManifestOrStatus(parent / kManifestFile);
    throw DataError(fmt::format("{}: is a file; {}", name,
                                stages.contains(TextOrEmpty(written, "stage"))
                                    ? "give the folder that it is in: " + parent.string()
                                    : "expected the folder that " + programs + " wrote"));
  }
  if (!fs::is_directory(folder, error)) {
    throw DataError(
        fmt::format("{}: there is no such folder; run {} with -o {} first", name, programs, name));
  }
  const json manifest = ReadManifestOrStatus(folder / kManifestFile),
             status = ReadManifestOrStatus(folder / kStatusFile);
  if (manifest.is_null() && status.is_null()) {
    throw DataError(
        fmt::format("{}: not a stage folder (it has no valid manifest.json); expected the folder "
                    "that {} wrote",
                    name, programs));
  }
  const json& known = manifest.is_null() ? status : manifest;
  const std::string stage = known["stage"];
  if (!stages.contains(stage)) {
    throw DataError(fmt::format("{}: is the folder of {}; expected the folder that {} wrote", name,
                                ProgramOf(stage), programs));
  }
  if (manifest.is_null() && fs::exists(folder / kManifestFile, error)) {
    throw DataError(
        fmt::format("{}: manifest.json is damaged; run {} again", name, ProgramOf(stage)));
  }
  if (manifest.is_null() && IsLocked(folder)) {
    throw DataError(fmt::format("{}: {} is still running there; wait until it has finished", name,
                                ProgramOf(stage)));
  }
  if (manifest.is_null()) {
    throw DataError(fmt::format("{}: {} did not finish there ({}); run it again", name,
                                ProgramOf(stage), StateAndErrorInWords(status)));
  }
  if (manifest["schema"] != kSchema) {
    throw DataError(fmt::format("{}: manifest.json has the schema {}, expected {}; run {} again",
                                name, manifest["schema"].dump(), kSchema, ProgramOf(stage)));
  }
  if (const std::string spoiled = FirstSpoiledOutput(folder, manifest); !spoiled.empty()) {
    throw DataError(fmt::format("{}: {} is missing or was changed since {} wrote it; run {} again",
                                name, spoiled, ProgramOf(stage), ProgramOf(stage)));
  }
  return manifest;
}

json ReadManifestOrStatus(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return nullptr;
  try {
    json value = ReadJson(path);
    const bool ours = value.is_object() && value.contains("schema") &&
                      value["schema"].is_number_integer() && value.contains("stage") &&
                      value["stage"].is_string() && value.contains("key") &&
                      value["key"].is_string();
    return ours ? value : nullptr;
  } catch (const DataError&) {
    return nullptr;
  }
}

std::optional<fs::path> PreviousFolder(const fs::path& folder, const json& manifest) {
  const std::string previous = TextOrEmpty(manifest, "previous");
  if (previous.empty()) return std::nullopt;
  // Recorded between the folders themselves; `folder` may be a link to one.
  return (fs::weakly_canonical(fs::absolute(folder)) / previous).lexically_normal();
}

void CheckIsMadeFrom(const fs::path& folder, const json& manifest, const fs::path& previous) {
  if (IsMadeFrom(manifest, ReadManifestOrStatus(previous / kManifestFile))) return;
  throw DataError(fmt::format(
      "{}: was recreated since {} was made from it; run {} and the stages after it again",
      previous.string(), folder.string(), ProgramOf(TextOrEmpty(manifest, "stage"))));
}

fs::path PreviousStage(const fs::path& folder, const std::set<std::string>& stages) {
  fs::path at = folder;
  for (int link = 0; link < kLongestChain; ++link) {
    const json manifest = ReadManifestOrStatus(at / kManifestFile);
    if (manifest.is_null()) {
      throw DataError(
          fmt::format("{}: is missing or unfinished, and {} was made from it; put it back there or "
                      "run the stages again",
                      at.string(), folder.string()));
    }
    const std::optional<fs::path> previous = PreviousFolder(at, manifest);
    if (!previous) break;
    CheckIsMadeFrom(at, manifest, *previous);
    const json written = ReadManifestOrStatus(*previous / kManifestFile);
    at = *previous;
    if (stages.contains(TextOrEmpty(written, "stage"))) {
      ReadManifest(at, stages);
      return at;
    }
  }
  throw DataError(fmt::format("{}: was not made from a folder of {}; run the stages again",
                              folder.string(), ProgramsOf(stages)));
}

std::string FirstSpoiledOutput(const fs::path& folder, const json& manifest) {
  const auto outputs = manifest.find("outputs");
  if (outputs == manifest.end() || !outputs->is_array()) return kManifestFile;
  for (const json& output : *outputs) {
    const std::string path = TextOrEmpty(output, "path"), hash = TextOrEmpty(output, "sha256");
    if (!StaysInFolder(path) || hash.empty() || !output.contains("bytes") ||
        !output["bytes"].is_number_unsigned())
      return kManifestFile;
    std::error_code error;
    if (fs::file_size(folder / path, error) != output["bytes"].get<uint64_t>() || error ||
        Sha256OfFile(folder / path) != hash)
      return path;
  }
  return "";
}

std::string StateInWords(const json& status) {
  const std::string state = TextOrEmpty(status, "status");
  if (state == "running") return "was killed before it finished";
  return state.empty() ? "unfinished" : state;
}

}  // namespace tetrec
