// Readers of volume files.
#include "volume/reader.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/lower_case.h"
#include "core/progress.h"
#include "volume/header.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

using internal::ParsedVolumeHeader;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 34;

// Decompresses gzip or zlib data to exactly `size` bytes.
std::vector<uint8_t> Inflate(std::span<const uint8_t> packed, size_t size,
                             const std::string& name) {
  // Deflate packs at best 1032 bytes into one, so larger claims are refused before memory is
  // allocated.
  if (size / 1032 > packed.size()) {
    throw DataError(fmt::format("{}: {} bytes of compressed samples cannot hold {}", name,
                                WithThousands(packed.size()), WithThousands(size)));
  }
  std::vector<uint8_t> unpacked(size);
  z_stream stream{};
  constexpr int kEitherHeader = 15 + 32;
  if (inflateInit2(&stream, kEitherHeader) != Z_OK) throw BugError("zlib does not start");
  constexpr size_t kMaxPart = size_t{1} << 30;  // zlib's counters have 32 bits
  size_t read = 0, written = 0;
  int state = Z_OK;
  while (state == Z_OK && written < size) {
    const size_t in = std::min(kMaxPart, packed.size() - read);
    const size_t out = std::min(kMaxPart, size - written);
    stream.next_in = const_cast<Bytef*>(packed.data() + read);
    stream.avail_in = uInt(in);
    stream.next_out = unpacked.data() + written;
    stream.avail_out = uInt(out);
    state = inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    written += out - stream.avail_out;
    if (in == stream.avail_in && out == stream.avail_out) break;  // nothing left to read
  }
  inflateEnd(&stream);
  if (written < size) {
    throw DataError(
        fmt::format("{}: the compressed samples are damaged or end after {} of {} "
                    "bytes",
                    name, WithThousands(written), WithThousands(size)));
  }
  return unpacked;
}

VolumeFile ReadSamples(const fs::path& path, std::vector<uint8_t> file,
                       const ParsedVolumeHeader& header, const ValueRange& range) {
  header.layout.Check(path.string());
  VolumeFile result;
  result.type = header.layout.type;
  result.unused_fields = header.unused_fields;
  result.data_file = path;
  const internal::SamplePlacement& placement = header.placement;
  size_t begin = header.header_bytes;
  if (!placement.data_file.empty()) {
    result.data_file = path.parent_path() / placement.data_file;
    file = ReadBytes(result.data_file, kMaxFileBytes);
    begin = 0;
  }
  const std::string name = result.data_file.string();
  const size_t size = header.layout.Bytes();
  const size_t available = file.size() - begin;
  if (placement.skip > available) {
    throw DataError(fmt::format("{}: has no sample after its first {} bytes", name,
                                WithThousands(placement.skip)));
  }
  begin += size_t(placement.skip);
  if (placement.skip_to_samples && available >= size) begin = file.size() - size;
  std::span<const uint8_t> samples = std::span(file).subspan(begin);
  if (placement.compressed) {
    const std::vector<uint8_t> unpacked = Inflate(samples, size, name);
    result.volume = DecodeVolume(header.layout, unpacked, name, range);
    return result;
  }
  if (samples.size() > size) {
    LogWarning("{}: {} bytes after the samples are ignored", name,
               WithThousands(samples.size() - size));
  }
  result.volume = DecodeVolume(header.layout, samples, name, range);
  return result;
}

ParsedVolumeHeader ParseHeader(const fs::path& path, std::span<const uint8_t> bytes) {
  const std::string extension = LowerExtension(path);
  return extension == ".nrrd" || extension == ".nhdr"
             ? internal::ParseNrrdHeader(bytes, path.string())
             : internal::ParseMetaImageHeader(bytes, path.string());
}

// Reads no samples. One byte more than a header may have shows whether it is too long.
ParsedVolumeHeader ReadHeader(const fs::path& path) {
  return ParseHeader(path, ReadFront(path, internal::kMaxVolumeHeaderBytes + 1));
}

}  // namespace

bool NeedsLayout(const fs::path& path) { return LowerExtension(path) == ".raw"; }

bool IsVolumeFile(const fs::path& path) {
  constexpr std::array kExtensions = {".raw", ".nrrd", ".nhdr", ".mha", ".mhd"};
  const std::string extension = LowerExtension(path);
  std::error_code unusable;
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
         !fs::is_directory(path, unusable);
}

VolumeFile ReadRawVolume(const fs::path& path, const VolumeLayout& layout,
                         const ValueRange& range) {
  layout.Check(path.string());
  const std::vector<uint8_t> bytes = ReadBytes(path, kMaxFileBytes);
  if (bytes.size() != layout.Bytes()) {
    throw DataError(fmt::format(
        "{}: has {} bytes, but {} x {} x {} samples of {} take {}; check the dimensions and the "
        "sample type",
        path.string(), WithThousands(bytes.size()), layout.size.x, layout.size.y, layout.size.z,
        Name(layout.type), WithThousands(layout.Bytes())));
  }
  return {DecodeVolume(layout, bytes, path.string(), range), layout.type, path, {}};
}

VolumeFile ParseVolume(std::vector<uint8_t> file, const fs::path& path, const ValueRange& range) {
  const ParsedVolumeHeader header = ParseHeader(path, file);
  return ReadSamples(path, std::move(file), header, range);
}

VolumeFile ReadVolume(const fs::path& path, const ValueRange& range) {
  return ParseVolume(ReadBytes(path, kMaxFileBytes), path, range);
}

VolumeLayout ReadVolumeLayout(const fs::path& path) {
  const VolumeLayout layout = ReadHeader(path).layout;
  layout.Check(path.string());
  return layout;
}

std::vector<fs::path> FilesNamedByVolume(const fs::path& path) {
  if (!IsVolumeFile(path) || NeedsLayout(path)) return {};
  const fs::path data_file = ReadHeader(path).placement.data_file;
  if (data_file.empty()) return {};
  return {path.parent_path() / data_file};
}

}  // namespace tetrec
