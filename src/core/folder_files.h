// The files in a folder that comes from outside.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace tetrec {

// All entries in the folder and its subfolders that are not folders, in no particular order. Links
// to folders are followed, after all real folders and in the order of their paths, except
// to folders that were entered before: they may lead in circles.
// Links that lead nowhere are listed. `enters`: returns false for a subfolder to leave out, by
// default none. Throws EnvironmentError naming the first folder that may not be listed, DataError
// for one that cannot be.
std::vector<std::filesystem::path> FilesBelow(
    const std::filesystem::path& folder,
    const std::function<bool(const std::filesystem::path&)>& enters = {});

}  // namespace tetrec
