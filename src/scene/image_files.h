// Where the images of a scene folder are stored.
#pragma once

#include <string>
#include <vector>

namespace tetrec {

// The files for images of these names, relative to the scene folder and in the same order:
// images/STEM.png, by the rules of PngFiles (image/file_names.h).
std::vector<std::string> ImageFiles(const std::vector<std::string>& names);

}  // namespace tetrec
