// An input of a stage: how the manifest records it, and the hash that stands for it in the key.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace tetrec {

// Other files that an input file names inside itself.
using FilesNamedBy =
    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)>;

struct StageInput {
  std::string name;
  std::filesystem::path path;
  nlohmann::json record;  // {"name", "path", "kind": "stage", "folder" or "file", "sha256", ...}
  std::map<std::string, std::string> hashes;  // for the key: of the input and of files it names
};

// Manifests name paths as text. Throws UsageError for one that they could not name.
void CheckPathIsText(const std::filesystem::path& path);

// `stages`: those of which one must have written the folder; empty for a path from outside, which
// may be a file (hashed, with the files that it names) or a folder (hashed by the names, sizes and
// times of its files). `output_folder` must not be inside of a folder that is an input. Throws
// DataError and UsageError.
StageInput ReadStageInput(const std::string& name, const std::filesystem::path& path,
                          const std::set<std::string>& stages,
                          const std::filesystem::path& output_folder,
                          const FilesNamedBy& files_of = {});

// Stands for the result of a finished stage: its outputs and all that they were made from. A later
// stage also reads the scene, which may have changed although what was made from it has not.
std::string HashOfResult(const nlohmann::json& manifest);

// SHA-256 of the value's compact text.
std::string HashOfJson(const nlohmann::json& value);

}  // namespace tetrec
