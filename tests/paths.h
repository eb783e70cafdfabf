// Where tests find files that are not compiled into them.
#pragma once

#include <filesystem>

namespace tetrec::test {

std::filesystem::path SourceFolder();   // the top of the repository
std::filesystem::path ProgramFolder();  // the folder of the executables
std::filesystem::path Python();         // the interpreter
// Data sets beside the project: $TETREC_DATASETS or ../shared/datasets. May not exist.
std::filesystem::path DatasetsFolder();

}  // namespace tetrec::test
