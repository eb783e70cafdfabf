// ASCII letters in lower case, whatever the locale.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tetrec {

inline std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return lower;
}

// The extension of a file's name in lower case, ".jpg" for "A.JPG".
inline std::string LowerExtension(const std::filesystem::path& path) {
  return Lower(path.extension().string());
}

}  // namespace tetrec
