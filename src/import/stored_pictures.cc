// The images of a data set as they are stored in the scene folder.
#include "import/stored_pictures.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/short_list.h"
#include "geometry/undistorted_camera.h"
#include "image/image.h"
#include "image/photo.h"
#include "image/scaled_copy.h"
#include "image/undistort.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetrec::internal {
namespace {

// The lens of a given field of view, with its principal point in the middle.
Lens LensOfFieldOfView(const PosedPicture& picture, const Image& image) {
  const auto focal_px = [](double fov_rad, int size) {
    return fov_rad == 0 ? 0.0 : 0.5 * size / std::tan(0.5 * fov_rad);
  };
  const double fx = focal_px(picture.horizontal_fov_rad, image.width);
  const double fy = focal_px(picture.vertical_fov_rad, image.height);
  return {LensModel::kPinhole,
          uint64_t(image.width),
          uint64_t(image.height),
          {fx == 0 ? fy : fx, fy == 0 ? fx : fy, 0.5 * image.width, 0.5 * image.height}};
}

glm::ivec2 SizeOf(const Image& image) { return {image.width, image.height}; }

// Reads the image that its camera took, or a scaled copy of it; notes what was done to it.
Image ReadPosed(const PosedPicture& picture, StoredPicture& stored) {
  Image image =
      ReadPicture(picture.file, stored.profile, ExifRotation::kIgnore, &stored.clipped_pixels);
  const glm::ivec2 wanted(picture.lens.width, picture.lens.height), size = SizeOf(image);
  if (wanted.x == 0 || size == wanted) return image;
  if (glm::ivec2(size.y, size.x) == wanted) {
    Image turned = ReadPicture(picture.file, stored.profile, ExifRotation::kApply);
    stored.turned = SizeOf(turned) == wanted && turned.channels == image.channels;
    if (stored.turned) return turned;
  }
  stored.lens_scaled = IsScaledCopy(size, wanted);
  if (stored.lens_scaled) return image;
  throw DataError(fmt::format(
      "{} has {} x {} pixels, its camera {} x {}, which is another aspect ratio; give the images "
      "that the cameras belong to",
      picture.file.string(), size.x, size.y, wanted.x, wanted.y));
}

Lens LensOf(const PosedPicture& picture, const Image& image, bool is_scaled) {
  if (picture.lens.width == 0) return LensOfFieldOfView(picture, image);
  return is_scaled ? ScaledLens(picture.lens, image.width, image.height) : picture.lens;
}

bool IsOpaque(const Image& image) {
  if (image.channels != 4) return true;
  for (size_t i = 3; i < image.pixels.size(); i += 4) {
    if (image.pixels[i] != 255) return false;
  }
  return true;
}

Image ReadAndApplyMask(const PosedPicture& picture, const Image& image, MaskUse use) {
  if (use == MaskUse::kIgnore && !IsOpaque(image)) {
    throw DataError(fmt::format(
        "{} has alpha and the mask {}; choose what masks mean: subject (what is black there is "
        "empty too) or none",
        picture.file.string(), picture.mask.string()));
  }
  const Image mask = ReadImage(picture.mask);
  if (SizeOf(mask) != SizeOf(image) && !IsScaledCopy(SizeOf(mask), SizeOf(image))) {
    throw DataError(
        fmt::format("{}: mask of {} x {} pixels for {} of {} x {}; expected the same aspect ratio",
                    picture.mask.string(), mask.width, mask.height, picture.file.string(),
                    image.width, image.height));
  }
  return MaskedBy(image, mask);
}

// The longer side of the stored image [px].
int LongerSide(const Image& image, const ImportOptions& options) {
  const int longer = std::max(image.width, image.height);
  if (options.downscale) return std::max(1, int(std::lround(longer / *options.downscale)));
  return options.max_size == 0 ? longer : std::min(longer, options.max_size);
}

// Scales each axis by itself, since both sides of an image are rounded.
Camera Scaled(const Lens& pinhole, const glm::ivec2& size) {
  const double x = size.x / double(pinhole.width), y = size.y / double(pinhole.height);
  const std::vector<double>& p = pinhole.params;
  return {size.x, size.y, p[0] * x, p[1] * y, p[2] * x, p[3] * y};
}

void CountHidden(const std::vector<uint8_t>& alpha, StoredPicture& stored) {
  for (const uint8_t value : alpha) {
    stored.hidden_pixels += value != 255;
    stored.masked_pixels += value < kSeenAlpha;
  }
}

// Undistorts and resizes one image and writes it.
StoredPicture StorePicture(const PosedPicture& picture, const std::filesystem::path& folder,
                           const ImportOptions& options) {
  StoredPicture stored;
  Image image = ReadPosed(picture, stored);
  const bool is_masked = !picture.mask.empty();
  if (is_masked) image = ReadAndApplyMask(picture, image, options.masks);
  const Lens lens = LensOf(picture, image, stored.lens_scaled);
  const int longer_side = LongerSide(image, options);
  if (lens.model == LensModel::kPinhole) {
    const glm::ivec2 size = FitToMaxSize(image.width, image.height, longer_side);
    stored.camera = Scaled(lens, size);
    stored.resized = size != glm::ivec2(image.width, image.height);
    if (stored.resized) image = ResizeByArea(image, size.x, size.y);
  } else {
    NamingLens(picture.file, lens, [&] {
      stored.camera = UndistortedCamera(lens, longer_side);
      stored.resized = true;
      stored.cut_to_plane = IsTooWideForPlane(lens);
      image = Undistort(image, lens, stored.camera);
    });
  }
  const std::filesystem::path path = folder / picture.image;
  std::filesystem::create_directories(path.parent_path());
  WriteImage(path, image);
  stored.has_mask = is_masked && options.masks == MaskUse::kIgnore;
  stored.has_alpha = image.channels == 4 && !stored.has_mask;
  if (image.channels != 4) return stored;
  std::vector<uint8_t> alpha = AlphaOf(image);
  CountHidden(alpha, stored);
  const uint8_t least_seen = stored.has_mask ? kSeenAlpha : 1;
  stored.shows_nothing =
      std::all_of(alpha.begin(), alpha.end(), [&](uint8_t value) { return value < least_seen; });
  if (stored.has_alpha && picture.split == Split::kTrain) stored.alpha = std::move(alpha);
  return stored;
}

}  // namespace

glm::ivec2 FitToMaxSize(int width, int height, int max_size) {
  const int longer = std::max(width, height);
  if (max_size == 0 || longer <= max_size) return {width, height};
  const double scale = double(max_size) / longer;
  return {std::max(1, int(std::lround(width * scale))),
          std::max(1, int(std::lround(height * scale)))};
}

void ChooseMasks(std::vector<PosedPicture>& pictures, MaskUse use) {
  std::vector<std::string> without, missing;
  for (PosedPicture& picture : pictures) {
    if (use == MaskUse::kNone) picture.mask.clear();
    if (picture.mask.empty()) without.push_back(picture.name);
    std::error_code unusable;
    if (!picture.mask.empty() && !std::filesystem::is_regular_file(picture.mask, unusable)) {
      missing.push_back(picture.mask.string());
    }
  }
  if (!missing.empty()) {
    throw DataError(fmt::format(
        "{} masks that the data set names are missing: {}; copy them there, or set masks to none",
        missing.size(), ShortList(missing)));
  }
  if (without.size() == pictures.size() && use == MaskUse::kSubject) {
    throw DataError("masks: subject needs masks, but the data set has none; leave it out");
  }
  if (without.empty() || without.size() == pictures.size()) return;
  throw DataError(fmt::format(
      "{} of {} images have no mask: {}; give each one, all white if it hides nothing, or set "
      "masks to none",
      without.size(), pictures.size(), ShortList(without)));
}

std::vector<StoredPicture> StorePictures(const std::vector<PosedPicture>& pictures,
                                         const std::filesystem::path& folder,
                                         const ImportOptions& options) {
  std::vector<StoredPicture> stored(pictures.size());
  ParallelForEach(pictures.size(), "images", "nothing is kept",
                  [&](size_t i) { stored[i] = StorePicture(pictures[i], folder, options); });
  return stored;
}

size_t DropIdleAlpha(const std::vector<PosedPicture>& pictures, const std::filesystem::path& folder,
                     std::vector<StoredPicture>& stored) {
  const bool hides = std::any_of(stored.begin(), stored.end(), [](const StoredPicture& picture) {
    return picture.hidden_pixels > 0;
  });
  if (hides) return 0;
  std::atomic<size_t> dropped = 0;
  ParallelFor(stored.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!stored[i].has_alpha && !stored[i].has_mask) continue;
      const std::filesystem::path path = folder / pictures[i].image;
      WriteImage(path, CompositeOver(ReadImage(path), 0, 0, 0));
      stored[i].has_alpha = stored[i].has_mask = false;
      stored[i].alpha.clear();
      ++dropped;
    }
  });
  return dropped;
}

void CheckSomethingShows(const std::vector<PosedPicture>& pictures,
                         const std::vector<StoredPicture>& stored) {
  std::vector<std::string> hidden;
  size_t training = 0, hidden_training = 0;
  for (size_t i = 0; i < stored.size(); ++i) {
    const bool trains = pictures[i].split == Split::kTrain;
    training += trains;
    if (!stored[i].shows_nothing) continue;
    hidden_training += trains;
    hidden.push_back(pictures[i].name);
  }
  if (hidden.empty()) return;
  const char* why = stored[0].has_mask ? "masks leave no pixel (128 to 255 in a mask counts)"
                                       : "alpha is 0 everywhere";
  if (hidden_training == training) {
    throw DataError(
        fmt::format("in all {} training images {}: nothing can be learnt from them; "
                    "check the files, or set masks to none",
                    training, why));
  }
  LogWarning("images in which {}: {}: {}", why, hidden.size(), ShortList(hidden));
}

void CheckAlike(const std::vector<PosedPicture>& pictures,
                const std::vector<StoredPicture>& stored) {
  for (size_t i = 1; i < stored.size(); ++i) {
    if (stored[i].has_alpha == stored[0].has_alpha && stored[i].has_mask == stored[0].has_mask)
      continue;
    throw DataError(fmt::format(
        "{} has {} alpha channel or mask, {} has {}; expected all images of a data set to be alike",
        pictures[i].file.string(), stored[i].has_alpha || stored[i].has_mask ? "an" : "no",
        pictures[0].file.string(), stored[0].has_alpha || stored[0].has_mask ? "one" : "none"));
  }
}

}  // namespace tetrec::internal
