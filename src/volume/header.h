// Headers of volume files: the text as fields by name, and the layout of the samples that they
// describe.
#pragma once

#include "volume/volume.h"

#include <charconv>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace tetrec::internal {

// Anything longer than this is not a header.
constexpr size_t kMaxVolumeHeaderBytes = size_t{1} << 20;

std::string_view Trimmed(std::string_view text);
std::vector<std::string_view> Words(std::string_view text);

// One value of a header and its place. The functions that read it throw DataError, which names the
// value, its place, and what was expected.
struct HeaderField {
  std::string name, text;
  std::string file;
  int line = 0;

  [[noreturn]] void Fail(const std::string& expected) const;
  template <class T>
  T NumberFrom(std::string_view word, const char* expected) const {
    T value{};
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) Fail(expected);
    return value;
  }
  double FiniteFrom(std::string_view word, const char* expected) const;
  glm::dvec3 Vector3(const char* expected) const;
  glm::ivec3 Size() const;  // samples along x, y and z
  int64_t Integer(const char* expected) const;
  bool Flag() const;
  // A file inside the folder of the header, relative to it.
  std::filesystem::path FileInside() const;
};

// The fields of a header by name; keeps track of those that were never asked for.
class VolumeHeader {
 public:
  explicit VolumeHeader(std::string file) : file_(std::move(file)) {}

  // Throws DataError if the field already exists.
  void Add(std::string name, std::string_view text, int line);
  const HeaderField* Find(const std::string& name);  // null if it is missing
  // The first field that exists, of several names for one thing.
  const HeaderField* FindAny(std::initializer_list<const char*> names);
  const HeaderField& Get(const std::string& name);  // throws DataError if it is missing
  std::vector<std::string> Unused() const;

 private:
  std::string file_;
  std::map<std::string, HeaderField> fields_;
  std::set<std::string> used_;
};

// The lines of a header at the beginning of a file.
class HeaderLines {
 public:
  HeaderLines(std::span<const uint8_t> bytes, std::string file)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), file_(std::move(file)) {}

  // Trimmed; nothing at the end of the file. Throws DataError if the header gets too long.
  std::optional<std::string_view> Next();
  size_t position() const { return position_; }  // of the byte after the last line
  int number() const { return number_; }         // of the last line, from 1

 private:
  std::string_view text_;
  std::string file_;
  size_t position_ = 0;
  int number_ = 0;
};

// Where the samples are according to a header.
struct SamplePlacement {
  std::filesystem::path data_file;  // empty: after the header
  uint64_t skip = 0;                // [bytes] to skip from there
  bool skip_to_samples = false;     // the samples are the last bytes of the file
  bool compressed = false;          // gzip or zlib
};

struct ParsedVolumeHeader {
  VolumeLayout layout;
  SamplePlacement placement;
  size_t header_bytes = 0;
  std::vector<std::string> unused_fields;
};

// Both throw DataError, which names the line, if a header is broken or describes something that is
// not supported.
ParsedVolumeHeader ParseNrrdHeader(std::span<const uint8_t> bytes, const std::string& name);
ParsedVolumeHeader ParseMetaImageHeader(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec::internal
