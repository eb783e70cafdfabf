// Failed checks, reported with their place in the source.
#include "core/error.h"

#include <filesystem>

namespace tetrec::internal {

void FailCheck(const char* condition, const char* file, int line, const std::string& message) {
  throw BugError("bug: " + message + " (" + condition + " does not hold, " +
                 std::filesystem::path(file).filename().string() + ":" + std::to_string(line) +
                 ")");
}

}  // namespace tetrec::internal
