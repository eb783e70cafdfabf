// Chooses which images of a data set are for training and which are held out.
#pragma once

#include "import/import.h"

namespace tetrec::internal {

// Follows the list of test views if one is given, then `options.holdout` if set, then the data
// set's own split; without one, or if it holds out nothing, every 8th view is held out. Empty lines
// of the list and those that start with # are ignored. Throws DataError if a listed name fits no
// image or several, if the list is empty, or if no view is left to train on.
void ChooseSplit(Dataset& set, const ImportOptions& options);

}  // namespace tetrec::internal
