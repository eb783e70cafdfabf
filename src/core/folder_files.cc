// Walks through folders.
#include "core/folder_files.h"

#include "core/error.h"

#include <fmt/format.h>

#include <set>
#include <system_error>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

void CheckListed(const fs::path& folder, const std::error_code& error) {
  if (!error) return;
  const std::string message =
      fmt::format("{}: cannot be listed ({})", folder.string(), error.message());
  if (error == std::errc::permission_denied) {
    throw EnvironmentError(message + "; make it readable, or move it elsewhere");
  }
  throw DataError(message);
}

}  // namespace

std::vector<fs::path> FilesBelow(const fs::path& folder,
                                 const std::function<bool(const fs::path&)>& enters) {
  std::vector<fs::path> files, waiting = {folder};
  std::set<fs::path> links, entered;
  while (!waiting.empty() || !links.empty()) {
    if (waiting.empty()) waiting.push_back(links.extract(links.begin()).value());
    const fs::path current = waiting.back();
    waiting.pop_back();
    std::error_code error;
    const fs::path itself = fs::canonical(current, error);
    CheckListed(current, error);
    if (!entered.insert(itself).second) continue;
    fs::directory_iterator entry(current, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
      std::error_code broken;  // a link that leads nowhere or to itself
      if (!entry->is_directory(broken)) {
        files.push_back(entry->path());
      } else if (!enters || enters(entry->path())) {
        if (entry->is_symlink(broken)) {
          links.insert(entry->path());
        } else {
          waiting.push_back(entry->path());
        }
      }
    }
    CheckListed(current, error);
  }
  return files;
}

}  // namespace tetrec
