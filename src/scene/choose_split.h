// Which pictures of a data set train and which are held out.
#pragma once

#include "scene/import.h"

namespace tetrec::internal {

// By the list of names, else by every n-th name, else as the data set says, else (also where its
// split holds out nothing) every 8th. In the list, empty lines and those with # mean nothing.
// Throws DataError (a name that no picture or that several have, none listed, none left to train
// on).
void ChooseSplit(Dataset& set, const ImportOptions& options);

}  // namespace tetrec::internal
