// The sizes of images in a few words.
#pragma once

#include <glm/glm.hpp>

#include <span>
#include <string>

namespace tetrec {

// The most frequent size, and the second one if there are two: "640×480 and 480×640 px". There is
// at least one.
std::string SizesInWords(std::span<const glm::ivec2> sizes_px);

}  // namespace tetrec
