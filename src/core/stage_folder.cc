// Declared paths, output records, and the removal of old runs.
#include "core/stage_folder.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/manifest.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// A folder with files in it that no stage wrote.
bool IsForeign(const fs::path& folder) {
  for (const char* file : {kManifestFile, kStatusFile}) {
    if (!ReadManifestOrStatus(folder / file).is_null()) return false;
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    // A run that was killed at its very start leaves no more than these.
    if (name != kLockFile && name != std::string(kStatusFile) + ".tmp") return true;
  }
  return false;
}

// True for something inside of one of the folders.
bool IsBelow(const fs::path& path, const std::set<std::string>& folders) {
  for (fs::path parent = path.parent_path(); !parent.empty(); parent = parent.parent_path()) {
    if (folders.contains(parent.string())) return true;
  }
  return false;
}

json FileRecord(const fs::path& folder, const fs::path& file) {
  return {{"path", file.lexically_relative(folder).generic_string()},
          {"bytes", fs::file_size(file)},
          {"sha256", Sha256OfFile(file)}};
}

}  // namespace

bool StaysInFolder(const fs::path& path) {
  if (path.empty() || path.is_absolute()) return false;
  return std::none_of(path.begin(), path.end(),
                      [](const fs::path& part) { return part == "." || part == ".."; });
}

std::string RelativeTo(const fs::path& path, const fs::path& folder) {
  // Absolute first: a relative path of which nothing exists yet stays relative when made canonical.
  return fs::weakly_canonical(fs::absolute(path))
      .lexically_relative(fs::weakly_canonical(fs::absolute(folder)))
      .generic_string();
}

void CheckFolderIsOurs(const fs::path& folder, const std::string& stage) {
  if (IsForeign(folder)) {
    throw UsageError(
        fmt::format("{} is not empty and not a stage folder; choose another", folder.string()));
  }
  for (const char* file : {kManifestFile, kStatusFile}) {
    const json old = ReadManifestOrStatus(folder / file);
    if (old.is_object() && old["stage"] != stage) {
      throw UsageError(fmt::format("{} is the folder of {}; choose another", folder.string(),
                                   ProgramOf(old["stage"].get<std::string>())));
    }
  }
}

std::set<std::string> DeclaredPaths(const json& status, const char* role) {
  std::set<std::string> paths;
  const auto list = status.is_object() ? status.find(role) : status.end();
  if (!status.is_object() || list == status.end() || !list->is_array()) return paths;
  for (const json& path : *list) {
    if (path.is_string() && StaysInFolder(path.get<std::string>()))
      paths.insert(path.get<std::string>());
  }
  return paths;
}

void RefuseLinks(const fs::path& folder, const json& status) {
  std::set<std::string> working = DeclaredPaths(status, "scratch");
  working.merge(DeclaredPaths(status, "caches"));
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error);
       !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    const fs::file_status kind = entry->symlink_status(error);
    if (error) break;
    if (fs::is_regular_file(kind) || fs::is_directory(kind)) continue;
    const fs::path& path = entry->path();
    if (!fs::is_symlink(kind) || !IsBelow(path.lexically_relative(folder), working)) {
      throw UsageError(
          fmt::format("{}: is a {}; a folder that a stage writes contains files and folders only: "
                      "remove it or choose another folder",
                      path.string(), fs::is_symlink(kind) ? "link" : "pipe or device"));
    }
    RemoveOwned(path);
  }
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be listed ({})", folder.string(), error.message()));
  }
}

void RemoveOwned(const fs::path& path) {
  std::error_code error;
  for (const fs::path& victim : {path, fs::path(path.string() + ".tmp")}) {
    fs::remove_all(victim, error);
    if (error) {
      throw EnvironmentError(
          fmt::format("{}: cannot be removed ({})", victim.string(), error.message()));
    }
  }
}

void RemoveDeclared(const fs::path& folder, const json& status, const char* role) {
  for (const std::string& path : DeclaredPaths(status, role)) RemoveOwned(folder / path);
}

std::set<std::string> ResultPaths(const json& manifest, const json& status) {
  std::set<std::string> paths = DeclaredPaths(status, "own");
  if (manifest.is_object() && manifest.contains("outputs") && manifest["outputs"].is_array()) {
    for (const json& output : manifest["outputs"]) {
      if (!output.is_object() || !output.contains("path") || !output["path"].is_string()) continue;
      const fs::path path = output["path"].get<std::string>();
      if (StaysInFolder(path)) paths.insert(path.begin()->string());
    }
  }
  return paths;
}

void RemoveOldRun(const fs::path& folder, const json& manifest, const json& status) {
  RemoveOwned(folder / kManifestFile);  // first: a half-removed folder must not look finished
  for (const std::string& path : ResultPaths(manifest, status)) RemoveOwned(folder / path);
}

json OutputRecords(const fs::path& folder, const std::set<std::string>& outputs) {
  std::set<fs::path> files;
  for (const std::string& relative : outputs) {
    const fs::path path = folder / relative;
    if (fs::is_directory(path)) {
      for (const auto& entry : fs::recursive_directory_iterator(path)) {
        if (entry.is_regular_file() && entry.path().extension() != ".tmp")
          files.insert(entry.path());
      }
    } else {
      TETREC_CHECK(fs::is_regular_file(path), "the stage did not write its output " + relative);
      files.insert(path);
    }
  }
  json records = json::array();
  for (const fs::path& file : files) records.push_back(FileRecord(folder, file));
  return records;
}

}  // namespace tetrec
