// The version of COLMAP that Tetrec is tested with; others differ in options and in the tables of
// their databases.
#pragma once

#include <fmt/format.h>

#include <string>

namespace tetrec {

constexpr const char* kTestedColmap = "3.8";

inline bool IsTestedColmap(const std::string& version) {
  return version == kTestedColmap || version.starts_with(std::string(kTestedColmap) + ".");
}

// For messages of failures that another version may be the cause of: which one was found, and which
// one to use.
inline std::string ColmapVersions(const std::string& found) {
  if (IsTestedColmap(found)) return fmt::format("COLMAP {} was found, the tested version", found);
  return fmt::format("COLMAP {} was found, {} is the tested version: install that one", found,
                     kTestedColmap);
}

}  // namespace tetrec
