// The files in a folder that comes from outside.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace tetrec {

// Returns all entries of the folder and its subfolders that are not folders, in no particular
// order. Links to folders are followed after all real folders, in the order of their paths, but
// never into a folder that was already entered, because links may form circles. Broken links are
// listed. `enters` returns false for a subfolder to leave out; by default none is. Throws
// EnvironmentError, naming the folder, if permission to list it is missing, and DataError if it
// cannot be listed for another reason.
std::vector<std::filesystem::path> FilesBelow(
    const std::filesystem::path& folder,
    const std::function<bool(const std::filesystem::path&)>& enters = {});

}  // namespace tetrec
