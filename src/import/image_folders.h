// Folders of images other than the one that a data set names: reduced copies, perhaps renamed.
#pragma once

#include "import/dataset.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// Throws UsageError if the folder of images leaves the data set's.
void CheckImagesFolder(const std::string& images);

// If the folder `images` does not exist, the name of the folder beside it in which reduced copies
// usually are (images_2, images_4, images_8), if that has `image`; otherwise empty.
std::string FindReducedCopies(const std::filesystem::path& images,
                              const std::filesystem::path& image);
// Advice for an error about images that are not there; empty without copies.
std::string AdviceOnCopies(const std::string& copies);

// JPEG, PNG and TIFF files below a folder, by their paths in it, sorted; hidden ones are left out.
std::vector<std::string> PhotosBelow(const std::filesystem::path& folder);

// Sets the files of those pictures, named by their paths in `originals`, that have none under their
// names in `images`: to those that differ in nothing but the extension; or, if there is none and no
// picture has a file, and both folders contain equally many photos, to those at the same places in
// sorted order. Logs what was found.
void FindRenamed(const std::filesystem::path& images, const std::filesystem::path& originals,
                 std::vector<PosedPicture>& pictures);

}  // namespace tetrec
