// manifest.json and status.json of a stage folder, and the chain that the manifests form.
//
// A stage writes status.json from its start on, and manifest.json last and by rename: a manifest
// exists only if the stage succeeded. The manifest of a stage names the folder of the stage before
// it ("previous", a relative path), so that a run can be followed back to its scene.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kManifestFile = "manifest.json";
inline constexpr const char* kStatusFile = "status.json";
// No chain has more links. Manifests come from outside and may point in a circle.
inline constexpr int kLongestChain = 16;

// "tetrec-optimize" for the stage "optimize".
std::string ProgramOf(const std::string& stage);

// The text in a field of a manifest, a status or a record; empty if it is missing or no text.
std::string TextOrEmpty(const nlohmann::json& object, const char* field);

// What a finished stage states about its run, besides what the writing itself adds: schema, program
// version and git revision, seed, previous folder, peak memory and time of day.
struct ManifestFacts {
  std::string stage;
  int version = 0;
  std::string key, command;
  nlohmann::json options;  // all of them, by name
  nlohmann::json inputs;   // records, see stage_input.h
  nlohmann::json outputs;  // records {"path", "bytes", "sha256"}, see stage_folder.h
  nlohmann::json device, counts, notes, seconds;
  std::vector<std::string> warnings, degraded;  // Stage::Degrade
  bool resumed = false;
};
void WriteManifest(const std::filesystem::path& folder, const ManifestFacts& facts);

// The status of a run that starts now. "own" (top names of outputs), "scratch" and "caches" list
// the paths that the run has declared so far; "status", "error" and "seconds" change as it ends.
nlohmann::json StatusOfNewRun(const std::string& stage, const std::string& key,
                              const nlohmann::json& options, const std::string& command);

// Reads manifest.json of a finished stage. Throws DataError: not a stage folder, the folder of
// another stage, or a stage that did not finish (with its state and what to run).
nlohmann::json ReadManifest(const std::filesystem::path& folder,
                            const std::set<std::string>& stages);

// manifest.json or status.json if the file exists and a stage wrote it; otherwise null.
nlohmann::json ReadManifestOrStatus(const std::filesystem::path& path);

// The folder of the stage before, as the manifest in `folder` names it.
std::optional<std::filesystem::path> PreviousFolder(const std::filesystem::path& folder,
                                                    const nlohmann::json& manifest);

// Throws DataError if `previous`, the stage before that of `manifest`, was recreated since `folder`
// was made from it. Folders without a manifest pass: others report them.
void CheckIsMadeFrom(const std::filesystem::path& folder, const nlohmann::json& manifest,
                     const std::filesystem::path& previous);

// The nearest folder before `folder` in the chain that one of `stages` wrote. Throws DataError if
// the chain ends before it, if its folder was moved away, or if a folder on the way was recreated
// since the next one was made from it: a field seen through another scene's cameras is wrong.
std::filesystem::path PreviousStage(const std::filesystem::path& folder,
                                    const std::set<std::string>& stages);

// The first listed output that is missing or has another content than the manifest's sha256
// (manifest.json itself if its list is invalid); empty if there is none. It reads all outputs: 1 GB
// takes about half a second on a processor with SHA instructions, and otherwise two to three.
std::string FirstSpoiledOutput(const std::filesystem::path& folder, const nlohmann::json& manifest);

// The state of a run that did not finish and no longer runs, such as "interrupted".
std::string StateInWords(const nlohmann::json& status);

}  // namespace tetrec
