// Files: bounded reading, writing by rename, JSON and hashes of files.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tetrec {

// All readers refuse what is not a regular file: a pipe could make them wait for ever, a device
// never ends.

// Reads a whole file. Throws DataError (missing, unreadable, larger than max_bytes).
std::vector<uint8_t> ReadBytes(const std::filesystem::path& path,
                               uint64_t max_bytes = uint64_t{1} << 34);
std::string ReadText(const std::filesystem::path& path, uint64_t max_bytes = uint64_t{1} << 30);
// Reads the first max_bytes of a file, or all if there are fewer. Throws DataError (missing,
// unreadable).
std::vector<uint8_t> ReadFront(const std::filesystem::path& path, size_t max_bytes);

// Writes a file piece by piece, for data that should not first be assembled in memory. It writes
// beside `path`; Finish syncs and renames, so that the final name never shows half a file, and
// without Finish nothing is left. A link at `path` is replaced, not followed. Throws
// EnvironmentError naming path, bytes and reason (disk full).
class FileWriter {
 public:
  // `bytes`: the size of all pieces together.
  FileWriter(std::filesystem::path path, uint64_t bytes);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  void Write(std::span<const uint8_t> piece);
  template <class T>
  void WriteArray(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Write({reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()});
  }
  void Finish();

 private:
  std::filesystem::path path_, temporary_;
  uint64_t bytes_ = 0, written_ = 0;
  int fd_ = -1;
  bool finished_ = false;
};

template <class T>
std::span<const uint8_t> BytesOf(const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)};
}

// One after another, by a FileWriter: what is large is not assembled in memory first.
void WritePieces(const std::filesystem::path& path,
                 std::span<const std::span<const uint8_t>> pieces);
// Writes all at once, by a FileWriter.
void WriteBytes(const std::filesystem::path& path, std::span<const uint8_t> bytes);
void WriteText(const std::filesystem::path& path, const std::string& text);

// Throws DataError with the name and the position of a syntax error, and for values nested deeper
// than 100 levels.
nlohmann::json ParseJson(std::string_view text, const std::string& name);
// Values take up to 25 times as much memory as their text.
inline constexpr uint64_t kMostBytesOfJson = uint64_t{1} << 27;
nlohmann::json ReadJson(const std::filesystem::path& path);
void WriteJson(const std::filesystem::path& path, const nlohmann::json& value);

// Lower-case hexadecimal SHA-256.
std::string Sha256(std::span<const uint8_t> bytes);
std::string Sha256(std::span<const std::span<const uint8_t>> pieces);
std::string Sha256OfFile(const std::filesystem::path& path);

// Reads plain little-endian values from a byte span; every read is checked against what remains and
// throws DataError("<name>: ends at byte N where <what> was expected").
class ByteReader {
 public:
  ByteReader(std::span<const uint8_t> bytes, std::string name)
      : bytes_(bytes), name_(std::move(name)) {}

  template <class T>
  T Read(const char* what) {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    Copy(&value, sizeof(T), what);
    return value;
  }
  // Reads `count` values; the count is checked against the remaining bytes before memory is
  // allocated.
  template <class T>
  std::vector<T> ReadArray(uint64_t count, const char* what) {
    CheckCount(count, sizeof(T), what);
    std::vector<T> values(count);
    if (count > 0) Copy(values.data(), count * sizeof(T), what);
    return values;
  }
  // Throws unless `count` records of at least `min_record_bytes` fit in the remaining bytes.
  void CheckCount(uint64_t count, uint64_t min_record_bytes, const char* what) const;
  void Copy(void* destination, size_t size, const char* what);
  // Throws unless everything has been read.
  void ExpectEnd() const;
  size_t position() const { return position_; }
  size_t remaining() const { return bytes_.size() - position_; }
  const std::string& name() const { return name_; }

 private:
  std::span<const uint8_t> bytes_;
  std::string name_;
  size_t position_ = 0;
};

class ByteWriter {
 public:
  template <class T>
  void Write(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    Append(&value, sizeof(T));
  }
  template <class T>
  void WriteArray(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!values.empty()) Append(values.data(), values.size_bytes());
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  // Not vector::insert: GCC 12 warns falsely about its memmove.
  void Append(const void* source, size_t size) {
    const size_t end = bytes_.size();
    bytes_.resize(end + size);
    std::memcpy(bytes_.data() + end, source, size);
  }

  std::vector<uint8_t> bytes_;
};

}  // namespace tetrec
