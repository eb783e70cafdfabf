// Where the images of a scene folder are stored.
#include "scene/image_files.h"

#include "image/file_names.h"

namespace tetrec {

std::vector<std::string> ImageFiles(const std::vector<std::string>& names) {
  std::vector<std::string> files = PngFiles(names, Folders::kKeep);
  for (std::string& file : files) file = "images/" + file;
  return files;
}

}  // namespace tetrec
