// Where tests find files that are not compiled into them.
#include "paths.h"

#include <cstdlib>

namespace tetrec::test {

std::filesystem::path SourceFolder() { return TETREC_SOURCE_DIR; }

std::filesystem::path ProgramFolder() { return TETREC_BIN_DIR; }

std::filesystem::path Python() { return TETREC_PYTHON; }

std::filesystem::path DatasetsFolder() {
  const char* datasets = std::getenv("TETREC_DATASETS");
  return datasets ? std::filesystem::path(datasets) : SourceFolder() / "../shared/datasets";
}

}  // namespace tetrec::test
