// Photos of one shade.
#pragma once

#include "image/image.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

namespace tetrec {

inline void WritePhoto(const std::filesystem::path& path, int shade, int width = 64) {
  std::filesystem::create_directories(path.parent_path());
  Image image{width, 48, 3, std::vector<uint8_t>(size_t(width) * 48 * 3, uint8_t(shade))};
  WriteImage(path, image);
}

// "photo 00.png" and so on, each brighter than the one before.
inline void WriteNumberedPhotos(const std::filesystem::path& folder, int count) {
  for (int i = 0; i < count; ++i)
    WritePhoto(folder / fmt::format("photo {:02}.png", i), 10 * i + 40);
}

}  // namespace tetrec
