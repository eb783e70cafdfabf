// The images of a data set as they are stored in the scene folder.
#pragma once

#include "image/color_profile.h"
#include "import/import.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec::internal {

// What remains in memory of an image after it was written.
struct StoredPicture {
  Camera camera;
  bool has_alpha = false;      // alpha is opacity
  bool has_mask = false;       // alpha excludes pixels
  uint64_t hidden_pixels = 0;  // by either, at least partly
  uint64_t masked_pixels = 0;
  bool shows_nothing = false;  // alpha is 0 everywhere, or the mask excludes all pixels
  bool resized = false, turned = false, lens_scaled = false;
  bool cut_to_plane = false;
  uint64_t clipped_pixels = 0;
  ProfileUse profile = ProfileUse::kNone;
  std::vector<uint8_t> alpha;  // of training images only
};

// Width and height scaled down so that the longer side is at most `max_size` (0: unlimited).
glm::ivec2 FitToMaxSize(int width, int height, int max_size);

// Drops masks that are not to be used; otherwise throws DataError unless all images have one or
// none has.
void ChooseMasks(std::vector<PosedPicture>& pictures, MaskUse use);

// Undistorts, resizes and writes all images, in parallel. Throws DataError for a file that is not
// an image, for an aspect ratio that differs from that of its camera or mask, and for a lens that
// cannot be undone, and Interrupted.
std::vector<StoredPicture> StorePictures(const std::vector<PosedPicture>& pictures,
                                         const std::filesystem::path& folder,
                                         const ImportOptions& options);

// Drops alpha that hides nothing in any image, such as that of screenshots. Returns the number of
// images that had such alpha.
size_t DropIdleAlpha(const std::vector<PosedPicture>& pictures, const std::filesystem::path& folder,
                     std::vector<StoredPicture>& stored);

// Throws DataError if alpha or masks hide all of every training image; warns about single images
// that are entirely hidden.
void CheckSomethingShows(const std::vector<PosedPicture>& pictures,
                         const std::vector<StoredPicture>& stored);

// Throws DataError if some images have alpha or a mask and others do not.
void CheckAlike(const std::vector<PosedPicture>& pictures,
                const std::vector<StoredPicture>& stored);

}  // namespace tetrec::internal
