// Images that a data set names but that are missing.
#pragma once

#include "import/dataset.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Missing pictures are those whose file is empty. kRefuse: throws a DataError that counts and names
// all of them and says what to do. kSkip: removes them from the set and notes their names; throws
// DataError if no training view is left. Their names are relative to `folder`; `tried` is a phrase
// for the error about the other ways in which they were looked for.
void HandleMissingPictures(const std::filesystem::path& folder, MissingPictures missing,
                           Dataset& set, const std::string& tried = "");

}  // namespace tetrec
