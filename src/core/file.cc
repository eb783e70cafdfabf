// Files: bounded reading, writing by rename, JSON and hashes of files.
#include "core/file.h"

#include "core/error.h"
#include "core/progress.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

FileDescriptor OpenForReading(const fs::path& path) {
  // The opening of a pipe would wait for a writer.
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0)
    throw DataError(fmt::format("{}: cannot be read ({})", path.string(), std::strerror(errno)));
  struct stat info {};
  if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    close(fd);
    throw DataError(fmt::format("{}: is not a file", path.string()));
  }
  return FileDescriptor(fd);
}

// Reads `size` bytes, fewer only at the end of the file.
size_t ReadSome(int fd, uint8_t* destination, size_t size, const fs::path& path) {
  size_t done = 0;
  while (done < size) {
    const ssize_t n = read(fd, destination + done, size - done);
    if (n == 0) break;
    if (n < 0 && errno == EINTR) continue;
    if (n < 0)
      throw DataError(fmt::format("{}: cannot be read ({})", path.string(), std::strerror(errno)));
    done += size_t(n);
  }
  return done;
}

[[noreturn]] void FailWrite(const fs::path& path, uint64_t bytes, int error) {
  const char* advice =
      error == ENOSPC || error == EDQUOT ? "; free some space and run it again" : "";
  throw EnvironmentError(fmt::format("{}: cannot write {} bytes ({}){}", path.string(),
                                     WithThousands(bytes), std::strerror(error), advice));
}

constexpr size_t kDeepestJson = 100;

std::string AsHex(const unsigned char* bytes, size_t size) {
  std::string text;
  for (size_t i = 0; i < size; ++i) text += fmt::format("{:02x}", bytes[i]);
  return text;
}

class Sha256State {
 public:
  Sha256State() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    TETREC_CHECK(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1,
                 "no SHA-256");
  }
  void Add(std::span<const uint8_t> bytes) {
    TETREC_CHECK(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1,
                 "SHA-256 failed");
  }
  std::string Finish() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    TETREC_CHECK(EVP_DigestFinal_ex(context_.get(), digest, &size) == 1, "SHA-256 failed");
    return AsHex(digest, size);
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

template <class Bytes>
Bytes ReadWhole(const fs::path& path, uint64_t max_bytes) {
  const FileDescriptor file = OpenForReading(path);
  struct stat info {};
  fstat(file.get(), &info);
  const auto size = uint64_t(info.st_size);
  if (size > max_bytes) {
    throw DataError(fmt::format("{}: has {} bytes; at most {} are read", path.string(),
                                WithThousands(size), WithThousands(max_bytes)));
  }
  Bytes bytes(size, {});
  const size_t done = ReadSome(file.get(), reinterpret_cast<uint8_t*>(bytes.data()), size, path);
  if (done != size) {
    throw DataError(fmt::format("{}: ends at byte {} of {}", path.string(), done, size));
  }
  return bytes;
}

}  // namespace

std::vector<uint8_t> ReadBytes(const fs::path& path, uint64_t max_bytes) {
  return ReadWhole<std::vector<uint8_t>>(path, max_bytes);
}

std::string ReadText(const fs::path& path, uint64_t max_bytes) {
  return ReadWhole<std::string>(path, max_bytes);
}

std::vector<uint8_t> ReadFront(const fs::path& path, size_t max_bytes) {
  const FileDescriptor file = OpenForReading(path);
  std::vector<uint8_t> bytes(max_bytes);
  bytes.resize(ReadSome(file.get(), bytes.data(), max_bytes, path));
  return bytes;
}

FileWriter::FileWriter(fs::path path, uint64_t bytes)
    : path_(std::move(path)), temporary_(path_.string() + ".tmp"), bytes_(bytes) {
  // A new file: what a killed run, or somebody else, left under this name may be a link to a file
  // that is not ours.
  unlink(temporary_.c_str());
  fd_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd_ < 0) FailWrite(path_, bytes_, errno);
}

FileWriter::~FileWriter() {
  if (fd_ >= 0) close(fd_);
  if (!finished_) unlink(temporary_.c_str());
}

void FileWriter::Write(std::span<const uint8_t> piece) {
  size_t done = 0;
  while (done < piece.size()) {
    const ssize_t n = write(fd_, piece.data() + done, piece.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) FailWrite(path_, bytes_, errno);
    done += size_t(n);
  }
  written_ += piece.size();
}

void FileWriter::Finish() {
  TETREC_CHECK(written_ == bytes_,
               fmt::format("{}: {} of {} bytes written", path_.string(), written_, bytes_));
  if (fsync(fd_) != 0 && errno != EINVAL) FailWrite(path_, bytes_, errno);
  if (close(std::exchange(fd_, -1)) != 0) FailWrite(path_, bytes_, errno);
  if (rename(temporary_.c_str(), path_.c_str()) != 0) FailWrite(path_, bytes_, errno);
  finished_ = true;
}

void WritePieces(const std::filesystem::path& path,
                 std::span<const std::span<const uint8_t>> pieces) {
  uint64_t bytes = 0;
  for (const auto& piece : pieces) bytes += piece.size();
  FileWriter writer(path, bytes);
  for (const auto& piece : pieces) writer.Write(piece);
  writer.Finish();
}

void WriteBytes(const fs::path& path, std::span<const uint8_t> bytes) {
  FileWriter writer(path, bytes.size());
  writer.Write(bytes);
  writer.Finish();
}

void WriteText(const fs::path& path, const std::string& text) {
  WriteBytes(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

namespace {

// The parser does not recurse, but copying and writing of what it returns do.
size_t DepthOfJson(std::string_view text) {
  size_t depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

nlohmann::json ParseJson(std::string_view text, const std::string& name) {
  if (const size_t depth = DepthOfJson(text); depth > kDeepestJson) {
    throw DataError(
        fmt::format("{}: is not valid JSON: {} levels of lists and objects; at most {} are read",
                    name, WithThousands(depth), kDeepestJson));
  }
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 7: ...", or out_of_range for
    // a number that does not fit in a double.
    std::string what = error.what();
    if (const size_t bracket = what.find("] "); bracket != std::string::npos)
      what.erase(0, bracket + 2);
    for (char& c : what) c = c == '\n' || c == '\r' ? ' ' : c;
    throw DataError(fmt::format("{}: is not valid JSON: {}", name, what));
  }
}

nlohmann::json ReadJson(const fs::path& path) {
  return ParseJson(ReadText(path, kMostBytesOfJson), path.string());
}

void WriteJson(const fs::path& path, const nlohmann::json& value) {
  // File names may contain bytes that are not UTF-8.
  WriteText(path, value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

std::string Sha256(std::span<const uint8_t> bytes) {
  Sha256State state;
  state.Add(bytes);
  return state.Finish();
}

std::string Sha256(std::span<const std::span<const uint8_t>> pieces) {
  Sha256State state;
  for (const auto& piece : pieces) state.Add(piece);
  return state.Finish();
}

std::string Sha256OfFile(const fs::path& path) {
  const FileDescriptor file = OpenForReading(path);
  Sha256State state;
  std::vector<uint8_t> block(size_t{1} << 20);
  while (const size_t n = ReadSome(file.get(), block.data(), block.size(), path)) {
    state.Add(std::span(block).first(n));
  }
  return state.Finish();
}

void ByteReader::CheckCount(uint64_t count, uint64_t min_record_bytes, const char* what) const {
  if (min_record_bytes > 0 && count > remaining() / min_record_bytes) {
    throw DataError(fmt::format("{}: byte {}: {} {} do not fit in the remaining {} bytes", name_,
                                position_, count, what, remaining()));
  }
}

void ByteReader::Copy(void* destination, size_t size, const char* what) {
  if (size > remaining()) {
    throw DataError(
        fmt::format("{}: ends at byte {} where {} was expected", name_, bytes_.size(), what));
  }
  std::memcpy(destination, bytes_.data() + position_, size);
  position_ += size;
}

void ByteReader::ExpectEnd() const {
  if (remaining() > 0) {
    throw DataError(
        fmt::format("{}: byte {}: {} bytes are left over", name_, position_, remaining()));
  }
}

}  // namespace tetrec
