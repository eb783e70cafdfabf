// Hashes of inputs.
#include "core/stage_input.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_files.h"
#include "core/manifest.h"
#include "core/printable.h"
#include "core/stage_folder.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// Names, sizes and times of the files inside: enough to see a change without reading gigabytes.
json ListingOf(const fs::path& folder) {
  json listing = json::array();
  for (const fs::path& file : FilesBelow(folder)) {
    std::error_code gone;
    if (!fs::is_regular_file(file, gone)) continue;
    listing.push_back({file.lexically_relative(folder).string(), fs::file_size(file),
                       int64_t(fs::last_write_time(file).time_since_epoch().count())});
  }
  std::sort(listing.begin(), listing.end());
  return listing;
}

void CheckOutputIsOutside(const fs::path& output_folder, const fs::path& input) {
  const fs::path relative = RelativeTo(output_folder, input);
  if (relative.empty() || *relative.begin() == "..") return;
  throw UsageError(fmt::format("the output folder {} is inside the input folder {}; choose another",
                               output_folder.string(), input.string()));
}

}  // namespace

void CheckPathIsText(const fs::path& path) {
  if (path.string() == Printable(path.string())) return;
  throw UsageError(fmt::format(
      "{}: a path that is not UTF-8 or contains control characters; rename it", path.string()));
}

StageInput ReadStageInput(const std::string& name, const fs::path& path,
                          const std::set<std::string>& stages, const fs::path& output_folder,
                          const FilesNamedBy& files_of) {
  CheckPathIsText(path);
  StageInput input = {.name = name, .path = path};
  input.record = {{"name", name}, {"path", RelativeTo(path, output_folder)}};
  if (!stages.empty()) {
    const json manifest = ReadManifest(path, stages);
    CheckOutputIsOutside(output_folder, path);
    input.record["kind"] = "stage";
    input.record["stage"] = manifest["stage"];
    input.record["sha256"] = HashOfResult(manifest);
  } else if (fs::is_directory(path)) {
    CheckOutputIsOutside(output_folder, path);
    input.record["kind"] = "folder";
    input.record["sha256"] = HashOfJson(ListingOf(path));
  } else if (fs::is_regular_file(path)) {
    input.record["kind"] = "file";
    input.record["sha256"] = Sha256OfFile(path);
    for (const fs::path& file : files_of ? files_of(path) : std::vector<fs::path>()) {
      const std::string hash = Sha256OfFile(file);
      input.record["names"].push_back(
          {{"path", RelativeTo(file, output_folder)}, {"sha256", hash}});
      input.hashes[name + " names " + file.filename().string()] = hash;
    }
  } else {
    throw DataError(fmt::format(
        "{}: {}", path.string(),
        fs::exists(path) ? "is neither a file nor a folder" : "there is no such file or folder"));
  }
  input.hashes[name] = input.record["sha256"];
  return input;
}

std::string HashOfResult(const json& manifest) {
  const json outputs = manifest.value("outputs", json::array());
  json sources = json::array();
  const auto inputs = manifest.find("inputs");
  if (inputs != manifest.end() && inputs->is_array()) {
    for (const json& input : *inputs) {
      if (TextOrEmpty(input, "kind") == "stage") sources.push_back(TextOrEmpty(input, "sha256"));
    }
  }
  return HashOfJson(sources.empty() ? outputs : json::array({outputs, sources}));
}

std::string HashOfJson(const json& value) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace tetrec
