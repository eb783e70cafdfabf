// Masks of photos: what is black in them neither helps to find cameras nor is modelled.
#include "sfm/masks.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_files.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "core/short_list.h"
#include "image/file_names.h"
#include "image/scaled_copy.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <utility>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// The images of the folder by their names without extension.
std::map<std::string, std::vector<std::string>> ImagesByStem(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw DataError(fmt::format("{}: is not a folder; give the folder that contains the masks",
                                folder.string()));
  }
  std::map<std::string, std::vector<std::string>> files;
  for (const fs::path& file : FilesBelow(folder)) {
    const std::string name = file.lexically_relative(folder).generic_string();
    const std::string stem = WithoutImageExtension(name);
    if (stem != name) files[stem].push_back(name);
  }
  for (auto& [stem, names] : files) std::sort(names.begin(), names.end());
  return files;
}

size_t CountSeen(const std::vector<uint8_t>& levels) {
  return size_t(std::count_if(levels.begin(), levels.end(),
                              [](uint8_t level) { return level >= kSeenAlpha; }));
}

// True for the size of the stored photo, and for smaller and larger ones of its shape.
bool HasShapeOf(const Photo& photo, const glm::ivec2& size) {
  const glm::ivec2 wanted(photo.width, photo.height);
  return size == wanted || IsScaledCopy(size, wanted);
}

// True if the photo is stored on its side and the mask fits only the upright photo.
bool IsPlainlyUpright(const fs::path& mask, const Photo& photo) {
  if (photo.quarter_turns % 2 == 0) return false;
  const Image image = ReadImage(mask);
  return !HasShapeOf(photo, {image.width, image.height}) &&
         HasShapeOf(photo, {image.height, image.width});
}

// Only masks of photos that are stored on their side can show this; if one of them is upright, all
// are taken to be.
void FindUprightMasks(const std::vector<fs::path>& masks, std::vector<Photo>& photos) {
  std::atomic<bool> are_upright = false;
  ParallelFor(masks.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end && !are_upright; ++i) {
      try {
        if (IsPlainlyUpright(masks[i], photos[i])) are_upright = true;
      } catch (const DataError&) {
        // ReadAll names all that cannot be read.
      }
    }
  });
  if (!are_upright) return;
  LogInfo("masks are upright, unlike the photos that are stored on their side");
  for (Photo& photo : photos) photo.mask_is_upright = photo.quarter_turns != 0;
}

// What reading a mask has found out.
struct MaskFacts {
  std::string error, sha256;
  size_t seen = 0, pixels = 0;
};

std::vector<MaskFacts> ReadAll(const std::vector<fs::path>& masks,
                               const std::vector<Photo>& photos) {
  std::vector<MaskFacts> facts(masks.size());
  ParallelForEach(masks.size(), "checking: mask", "nothing was done yet", [&](size_t i) {
    try {
      const std::vector<uint8_t> levels = ReadMask(masks[i], photos[i]);
      facts[i] = {"", Sha256OfFile(masks[i]), CountSeen(levels), levels.size()};
    } catch (const DataError& error) {
      facts[i].error = error.what();
    }
  });
  std::vector<std::string> errors;
  for (const MaskFacts& mask : facts) {
    if (!mask.error.empty()) errors.push_back(mask.error);
  }
  if (!errors.empty()) {
    throw DataError(fmt::format("{} of {} masks cannot be used: {}", errors.size(), masks.size(),
                                ShortList(errors)));
  }
  return facts;
}

}  // namespace

std::vector<fs::path> FindMasks(const fs::path& folder, const std::vector<Photo>& photos) {
  const std::map<std::string, std::vector<std::string>> files = ImagesByStem(folder);
  std::vector<fs::path> masks;
  std::vector<std::string> without;
  std::map<std::string, std::string> photo_of_mask;
  for (const Photo& photo : photos) {
    auto found = files.find(photo.name);
    if (found == files.end()) {
      found = files.find(fs::path(photo.name).replace_extension().generic_string());
    }
    if (found == files.end()) {
      without.push_back(photo.name);
      continue;
    }
    const std::vector<std::string>& names = found->second;
    if (names.size() > 1) {
      throw DataError(fmt::format("{}: the photo {} has {} masks ({}); keep one of them",
                                  folder.string(), photo.name, names.size(), ShortList(names)));
    }
    const auto [other, is_new] = photo_of_mask.emplace(names[0], photo.name);
    if (!is_new) {
      throw DataError(fmt::format(
          "{}: {} is the mask of both {} and {}; name the masks {}.png and {}.png", folder.string(),
          names[0], other->second, photo.name, other->second, photo.name));
    }
    masks.push_back(folder / names[0]);
  }
  if (!without.empty()) {
    throw DataError(fmt::format(
        "{}: {} of {} photos have no mask: {}; give each one, all white if it hides nothing, "
        "named like {}.png",
        folder.string(), without.size(), photos.size(), ShortList(without), without[0]));
  }
  std::vector<std::string> others;
  for (const auto& [stem, names] : files) {
    for (const std::string& name : names) {
      if (!photo_of_mask.contains(name)) others.push_back(Printable(name));
    }
  }
  if (!others.empty()) {
    LogInfo("{}: images that are the mask of no photo are ignored: {}: {}", folder.string(),
            others.size(), ShortList(others));
  }
  return masks;
}

std::vector<uint8_t> ReadMask(const fs::path& path, const Photo& photo) {
  Image mask = ReadImage(path);
  const glm::ivec2 size(mask.width, mask.height);
  if (photo.mask_is_upright) mask = TurnedClockwise(mask, 4 - photo.quarter_turns);
  if (!HasShapeOf(photo, {mask.width, mask.height})) {
    glm::ivec2 expected(photo.width, photo.height);
    if (photo.mask_is_upright && photo.quarter_turns % 2 == 1) std::swap(expected.x, expected.y);
    throw DataError(fmt::format(
        "{}: mask of {} x {} pixels for a photo of {} x {}{}; expected the same aspect ratio",
        path.string(), size.x, size.y, expected.x, expected.y,
        photo.mask_is_upright ? " when it is upright, as other masks are" : ""));
  }
  return AlphaOf(MaskedBy(MakeImage(photo.width, photo.height, 3), mask));
}

std::vector<std::string> AddMasks(const fs::path& folder, std::vector<Photo>& photos) {
  const std::vector<fs::path> masks = FindMasks(folder, photos);
  FindUprightMasks(masks, photos);
  const std::vector<MaskFacts> facts = ReadAll(masks, photos);
  double seen = 0, pixels = 0;
  for (const MaskFacts& mask : facts) {
    seen += double(mask.seen);
    pixels += double(mask.pixels);
  }
  if (seen == pixels) {
    LogInfo("{}: no mask hides anything", folder.string());
    return {};
  }
  LogInfo("masks exclude {:.1f} % of all pixels", 100 * (1 - seen / pixels));
  std::vector<std::string> hidden;
  std::vector<Photo> kept;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (facts[i].seen == 0) {
      hidden.push_back(photos[i].name);
      continue;
    }
    kept.push_back(photos[i]);
    kept.back().mask = masks[i];
    kept.back().mask_sha256 = facts[i].sha256;
  }
  if (kept.size() < kFewestPhotos) {
    throw DataError(
        fmt::format("{}: the masks of {} of {} photos leave no pixel (128 to 255 in a mask is "
                    "used): {}; white is what is used, perhaps they are inverted",
                    folder.string(), hidden.size(), photos.size(), ShortList(hidden)));
  }
  if (!hidden.empty()) {
    LogWarning("photos whose masks leave no pixel are left out: {}: {}", hidden.size(),
               ShortList(hidden));
  }
  photos = std::move(kept);
  return hidden;
}

Image MaskedPhoto(const Image& rgb, const Photo& photo) {
  Image rgba = MakeImage(rgb.width, rgb.height, 4);
  const std::vector<uint8_t> levels = ReadMask(photo.mask, photo);
  for (size_t i = 0; i < levels.size(); ++i) {
    std::copy_n(&rgb.pixels[3 * i], 3, &rgba.pixels[4 * i]);
    rgba.pixels[4 * i + 3] = levels[i];
  }
  return rgba;
}

void WriteColmapMask(const fs::path& path, const Photo& photo) {
  const std::vector<uint8_t> levels = ReadMask(photo.mask, photo);
  Image mask = MakeImage(photo.width, photo.height, 3);
  for (size_t i = 0; i < levels.size(); ++i) {
    std::fill_n(&mask.pixels[3 * i], 3, uint8_t(levels[i] >= kSeenAlpha ? 255 : 0));
  }
  WriteImage(path, mask);
}

}  // namespace tetrec
