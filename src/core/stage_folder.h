// The files of a stage folder: which of them belong to a run, and how an old run is removed.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <set>
#include <string>

namespace tetrec {

inline constexpr const char* kLogFileName = "log.txt";

// True for a relative path to something inside the folder; paths that files give may be hostile.
bool StaysInFolder(const std::filesystem::path& path);

// The path relative to `folder`, both resolved.
std::string RelativeTo(const std::filesystem::path& path, const std::filesystem::path& folder);

// Throws UsageError unless the folder is empty, or a folder of `stage`.
void CheckFolderIsOurs(const std::filesystem::path& folder, const std::string& stage);

// The paths that a run has declared in the role "own" (top names of outputs), "scratch" or
// "caches".
std::set<std::string> DeclaredPaths(const nlohmann::json& status, const char* role);

// A stage opens, writes and removes nothing outside of its folder, whatever somebody left inside:
// throws UsageError if the folder contains anything but files and folders, at any depth. Links in
// the scratch and the caches of the run with this status (may be null) are those of a stage that
// was killed; they are removed, never followed. Another process that changes the folder while the
// stage runs is not guarded against.
void RefuseLinks(const std::filesystem::path& folder, const nlohmann::json& status);

// Removes a file or folder, and the half-written file that a killed process left beside it. Throws
// EnvironmentError.
void RemoveOwned(const std::filesystem::path& path);

// Removes what a run has declared in this role. Throws EnvironmentError.
void RemoveDeclared(const std::filesystem::path& folder, const nlohmann::json& status,
                    const char* role);

// The paths in the folder that belong to the result of the run with this manifest and status
// (either may be null): top names of its outputs.
std::set<std::string> ResultPaths(const nlohmann::json& manifest, const nlohmann::json& status);

// Removes the result that the run with this manifest and status (either may be null) wrote, and
// never the user's own files. Its log, scratch and caches stay.
void RemoveOldRun(const std::filesystem::path& folder, const nlohmann::json& manifest,
                  const nlohmann::json& status);

// Records {"path", "bytes", "sha256"} of all files in these outputs. A missing output is a bug.
nlohmann::json OutputRecords(const std::filesystem::path& folder,
                             const std::set<std::string>& outputs);

}  // namespace tetrec
