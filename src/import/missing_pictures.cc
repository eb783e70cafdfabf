// Images that a data set names but that are missing.
#include "import/missing_pictures.h"

#include "core/error.h"
#include "core/short_list.h"
#include "image/image.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// A folder with photos, which tetrec-sfm could use; empty if there is none.
fs::path FolderOfPhotos(const fs::path& folder, const Dataset& set) {
  for (const PosedPicture& picture : set.pictures) {
    if (HasPhotoExtension(picture.file)) return picture.file.parent_path();
  }
  std::error_code unreadable;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied,
                                         unreadable);
  for (; !unreadable && entry != fs::recursive_directory_iterator(); entry.increment(unreadable)) {
    std::error_code gone;
    if (HasPhotoExtension(entry->path()) && entry->is_regular_file(gone)) {
      return entry->path().parent_path();
    }
  }
  return {};
}

[[noreturn]] void Refuse(const fs::path& folder, const Dataset& set,
                         const std::vector<std::string>& names, const MissingPhrases& phrases) {
  const bool all = names.size() == set.pictures.size();
  std::string message =
      fmt::format("{}: {} of {} images are missing{}: {}; {}{}", folder.string(), names.size(),
                  set.pictures.size(), phrases.tried, ShortList(names),
                  all ? "copy them there (skipping missing images needs some that exist)"
                      : "copy them there, or skip missing images",
                  phrases.advice);
  if (const fs::path photos = FolderOfPhotos(folder, set); !photos.empty()) {
    message += fmt::format("; tetrec-sfm finds new cameras for the images in {}", photos.string());
  }
  throw DataError(message);
}

}  // namespace

void HandleMissingPictures(const fs::path& folder, MissingPictures missing, Dataset& set,
                           const MissingPhrases& phrases) {
  std::vector<std::string> names;
  for (const PosedPicture& picture : set.pictures) {
    if (picture.file.empty()) names.push_back(picture.name);
  }
  if (names.empty()) return;
  const size_t count = set.pictures.size();
  if (missing == MissingPictures::kRefuse || names.size() == count)
    Refuse(folder, set, names, phrases);
  std::erase_if(set.pictures, [](const PosedPicture& picture) { return picture.file.empty(); });
  const bool has_training =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split == Split::kTrain; });
  if (!has_training) {
    throw DataError(
        fmt::format("{}: without the missing images there is no view to train on: {} of {} images "
                    "are missing{}: {}",
                    folder.string(), names.size(), count, phrases.tried, ShortList(names)));
  }
  set.skipped = std::move(names);
}

}  // namespace tetrec
