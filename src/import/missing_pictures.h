// Images that a data set names but that are missing.
#pragma once

#include "import/dataset.h"

#include <filesystem>
#include <string>

namespace tetrec {

// Phrases for the error.
struct MissingPhrases {
  std::string tried = {};   // in which other ways images were looked for
  std::string advice = {};  // what else to do
};

// Missing pictures are those whose file is empty. kRefuse: throws a DataError that counts and names
// all of them and advises what to do. kSkip: removes them from the set and notes their names;
// throws DataError if no training view is left. Their names are relative to `folder`.
void HandleMissingPictures(const std::filesystem::path& folder, MissingPictures missing,
                           Dataset& set, const MissingPhrases& phrases = {});

}  // namespace tetrec
