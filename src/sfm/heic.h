// HEIC photos, as phones write them, by heif-convert as a child process: a decoder that a damaged
// file breaks, or makes ask for all memory, breaks nothing else.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace tetrec {

// By the first 12 bytes of a file.
bool IsHeic(std::span<const uint8_t> front);

// Writes the photo as JPEG of the highest quality, turned as its file prescribes, with its EXIF.
// `scratch` is a folder of this call alone. Throws DataError, and EnvironmentError if heif-convert
// is not installed or cannot write.
void ConvertHeic(const std::filesystem::path& photo, const std::filesystem::path& jpeg,
                 const std::filesystem::path& scratch);

}  // namespace tetrec
