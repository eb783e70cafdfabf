// Masks of photos: what is black in them neither helps to find cameras nor is modelled.
#pragma once

#include "image/image.h"
#include "sfm/photos.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// The mask of each photo, in their order. That of a/b.jpg is a/b.jpg.png, as COLMAP names it, or
// a/b with the extension of any image. Throws DataError unless each photo has exactly one, which is
// no other's.
std::vector<std::filesystem::path> FindMasks(const std::filesystem::path& folder,
                                             const std::vector<Photo>& photos);

// The mask's levels for the photo's pixels as they are stored, row by row: those of at least
// kSeenAlpha are used. A mask of another size is resampled. Throws DataError if it has another
// shape than the stored photo or, if it is upright, than the upright one.
std::vector<uint8_t> ReadMask(const std::filesystem::path& mask, const Photo& photo);

// Gives the photos their masks. All are read, and one error names all that cannot be used. Masks
// are as their photos are stored, or upright if the shape of one of them shows it: some programs
// turn images by their EXIF, others do not. Photos whose masks leave no pixel are removed, with a
// warning; their names are returned. If no mask hides anything, no photo gets one.
std::vector<std::string> AddMasks(const std::filesystem::path& folder, std::vector<Photo>& photos);

// The photo's image with its mask as alpha.
Image MaskedPhoto(const Image& rgb, const Photo& photo);

// Writes the mask as COLMAP reads it: 0 where no feature may be.
void WriteColmapMask(const std::filesystem::path& path, const Photo& photo);

}  // namespace tetrec
