// The pictures of a data set as the scene folder has them.
#pragma once

#include "scene/import.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec::internal {

// What is kept of a picture once it is written.
struct StoredPicture {
  Camera camera;
  bool has_alpha = false;      // of opacity
  bool has_mask = false;       // alpha that leaves pixels out
  uint64_t hidden_pixels = 0;  // by either, at least in part
  uint64_t masked_pixels = 0;
  bool shows_nothing = false;  // alpha 0 everywhere, or a mask that leaves no pixel
  bool resized = false, turned = false, lens_scaled = false;
  bool cut_to_plane = false;
  uint64_t clipped_pixels = 0;
  std::vector<uint8_t> alpha;  // training pictures only
};

// Width and height scaled down so that the longer side is at most `max_size` (0: no bound).
glm::ivec2 FitToMaxSize(int width, int height, int max_size);

// Of the stored picture, relative to the scene folder.
std::string ImageOf(const PosedPicture& picture);

// Drops masks that are not wanted; else all pictures must have one, or none: throws DataError.
void ChooseMasks(std::vector<PosedPicture>& pictures, MaskUse use);

// Brings each picture to a pinhole camera and to size, and writes it, in parallel. Throws DataError
// (no picture, another shape than its camera's or its mask's, a lens that cannot be undone) and
// Interrupted.
std::vector<StoredPicture> StorePictures(const std::vector<PosedPicture>& pictures,
                                         const std::filesystem::path& folder,
                                         const ImportOptions& options);

// Alpha that hides nothing in any picture, as of screenshots, is none: drops it. Returns of how
// many pictures.
size_t DropIdleAlpha(const std::vector<PosedPicture>& pictures, const std::filesystem::path& folder,
                     std::vector<StoredPicture>& stored);

// Throws DataError where alpha or masks leave nothing of any training picture; warns of single
// pictures of which they leave nothing.
void CheckSomethingShows(const std::vector<PosedPicture>& pictures,
                         const std::vector<StoredPicture>& stored);

// Throws DataError where some pictures have alpha or a mask and others do not.
void CheckAlike(const std::vector<PosedPicture>& pictures,
                const std::vector<StoredPicture>& stored);

}  // namespace tetrec::internal
