// What every fuzz target does around the one call that it tests.
#pragma once

#include "core/error.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace fuzz {

// At exit: prints how many inputs were accepted. If none was, the seeds are of an older format, and
// nothing behind the first check was reached.
struct AcceptedInputs {
  ~AcceptedInputs() { std::printf("Accepted %zu inputs\n", count); }
  size_t count = 0;
};

// A reader may refuse its input with one kind of error; every other exception, signal, sanitizer
// report or excess of memory or time is a finding.
template <class Refusal = tetrec::DataError, class Body>
int Refusing(const Body& body) {
  static AcceptedInputs accepted;
  try {
    body();
    ++accepted.count;
  } catch (const Refusal&) {
  }
  return 0;
}

// For what must not be refused: an exception leaves a noexcept function only by ending the process.
template <class Body>
void Succeeding(const Body& body) noexcept {
  body();
}

// A folder of this process's own for readers that take files; removed at exit.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tetrec-fuzz-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  void Write(const std::string& name, std::span<const uint8_t> bytes) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    if (!out) std::abort();
  }

 private:
  std::filesystem::path path_;
};

}  // namespace fuzz
