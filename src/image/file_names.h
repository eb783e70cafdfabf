// Names of PNG files that are made from images with given names.
#pragma once

#include <string>
#include <vector>

namespace tetrec {

// "a/frame.0001.jpg" becomes "a/frame.0001". Only the extension of an image format is dropped;
// anything else behind a dot, such as the number, belongs to the name.
std::string WithoutImageExtension(const std::string& name);

// kFlatten: "test/r_0" becomes the file test_r_0.png, not r_0.png in a folder.
enum class Folders { kKeep, kFlatten };

// The files for images of these names, in the same order: STEM.png. If two files would coincide,
// all keep their extension (a.jpg.png); if that does not help either, or a name is too long for a
// file system, all are numbered. Different
// names always give different files, and no file is in a folder that has the name of another.
std::vector<std::string> PngFiles(const std::vector<std::string>& names, Folders folders);

}  // namespace tetrec
