// The version of COLMAP that Tetrec is tested with. Others have other options and other tables in
// their databases.
#pragma once

#include <fmt/format.h>

#include <string>

namespace tetrec {

constexpr const char* kTestedColmap = "3.8";

inline bool IsTestedColmap(const std::string& version) {
  return version == kTestedColmap || version.starts_with(std::string(kTestedColmap) + ".");
}

// For failures that another version may cause: the version found and the one to use.
inline std::string ColmapVersions(const std::string& found) {
  if (IsTestedColmap(found)) return fmt::format("COLMAP {} was found, the tested version", found);
  return fmt::format("COLMAP {} was found, {} is the tested version: install that one", found,
                     kTestedColmap);
}

}  // namespace tetrec
