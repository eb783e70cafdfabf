// What a folder of photos contains if it is a data set: cameras that are not read, reduced copies.
#pragma once

#include <filesystem>

namespace tetrec {

// Warns if the folder has known cameras in a format that tetrec-import does not read (NeuS, IDR,
// LLFF, NSVF, MVSNet), since they are ignored; names its folder of images, if there is one.
void WarnOfUnreadCameras(const std::filesystem::path& folder);

// True for images_2, images_4 and images_8 beside a folder images with at least as many files: they
// contain the same photos in smaller sizes.
bool HasReducedCopies(const std::filesystem::path& folder);

}  // namespace tetrec
