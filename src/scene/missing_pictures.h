// Pictures that a data set names and that are not there.
#pragma once

#include "scene/dataset.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Looks at the pictures whose file is empty. kRefuse: throws DataError that counts and names them
// all and says what can be done. kSkip: takes them out of the set and notes their names; throws
// DataError where no training view is left. `folder` is what their names are relative to; `tried`
// says how else they were looked for.
void HandleMissingPictures(const std::filesystem::path& folder, MissingPictures missing,
                           Dataset& set, const std::string& tried = "");

}  // namespace tetrec
