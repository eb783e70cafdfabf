// Which pictures of a data set train and which are held out.
#pragma once

#include "scene/import.h"

namespace tetrec::internal {

// By the list of names, else by every n-th name, else as the data set says, else every 8th. Throws
// DataError (a name that no picture or that several have, none listed, none left to train on).
void ChooseSplit(Dataset& set, const ImportOptions& options);

}  // namespace tetrec::internal
