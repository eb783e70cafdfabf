// Names of PNG files that are made from images with given names.
#include "image/file_names.h"

#include "core/lower_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

// What cameras and photogrammetry programs write, whether or not it can be read here.
constexpr std::array<std::string_view, 11> kExtensions = {
    ".png", ".jpg", ".jpeg", ".exr", ".tif", ".tiff", ".bmp", ".webp", ".heic", ".heif", ".hif"};

// File systems allow 255 bytes, of which a file that is being written needs some.
constexpr size_t kLongestName = 240;

bool HasLongName(const fs::path& file) {
  return std::any_of(file.begin(), file.end(),
                     [](const fs::path& part) { return part.string().size() > kLongestName; });
}

// True if all files can be written, no two coincide and none has the name of a folder that another
// one is in.
bool AreApart(const std::vector<std::string>& files) {
  std::set<fs::path> known;
  for (const std::string& file : files) {
    if (HasLongName(file) || !known.insert(fs::path(file).lexically_normal()).second) return false;
  }
  for (const fs::path& file : known) {
    for (fs::path folder = file.parent_path(); folder.has_relative_path();
         folder = folder.parent_path()) {
      if (known.contains(folder)) return false;
    }
  }
  return true;
}

}  // namespace

std::string WithoutImageExtension(const std::string& name) {
  const std::string extension = LowerExtension(name);
  const bool is_known =
      std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
  return is_known ? name.substr(0, name.size() - extension.size()) : name;
}

std::vector<std::string> PngFiles(const std::vector<std::string>& names, Folders folders) {
  std::vector<std::string> by_stem, by_name, by_number;
  for (std::string name : names) {
    if (folders == Folders::kFlatten) std::replace(name.begin(), name.end(), '/', '_');
    by_stem.push_back(fmt::format("{}.png", WithoutImageExtension(name)));
    by_name.push_back(fmt::format("{}.png", name));
    by_number.push_back(fmt::format("{:06}.png", by_number.size()));
  }
  if (AreApart(by_stem)) return by_stem;
  return AreApart(by_name) ? by_name : by_number;
}

}  // namespace tetrec
