// Limits on the sizes that an image file states, checked before memory is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tetrec {

inline constexpr size_t kMostColorProfile_bytes = size_t{1} << 22;  // a printer's has fewer

// Throws DataError unless there are 1 to 65,536 pixels per side and at most 2^28 in total.
void CheckSize(uint64_t width, uint64_t height, const std::string& name);

// Throws DataError if no compression makes so many bytes of pixels of a file of this size: a short
// file then costs little memory, whatever it claims.
void CheckAgainstFile(uint64_t pixel_bytes, uint64_t file_bytes, const std::string& name);

}  // namespace tetrec
