// Hashes of inputs.
#include "core/stage_input.h"

#include "core/error.h"
#include "core/file.h"
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
// Links to folders are followed, except to folders already listed: they may lead in circles.
json ListingOf(const fs::path& folder) {
  json listing = json::array();
  std::set<fs::path> entered = {fs::canonical(folder)};
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink,
                                         error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code gone;
    if (entry->is_directory(gone) && !entered.insert(fs::canonical(entry->path())).second) {
      entry.disable_recursion_pending();
    }
    if (!entry->is_regular_file(gone)) continue;
    listing.push_back({entry->path().lexically_relative(folder).string(), entry->file_size(),
                       int64_t(entry->last_write_time().time_since_epoch().count())});
  }
  if (error) {
    const std::string message =
        fmt::format("{}: cannot be listed ({})", folder.string(), error.message());
    if (error == std::errc::permission_denied) throw EnvironmentError(message);
    throw DataError(message);
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
    input.record["sha256"] = HashOfJson(manifest["outputs"]);
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

std::string HashOfJson(const json& value) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace tetrec
