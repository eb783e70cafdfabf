// Layouts of volumes, and decoding of their samples.
#include "volume/volume.h"

#include "core/error.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace tetrec {
namespace {

constexpr int kMaxSide = 1 << 16;

// The i-th value of type T.
template <class T>
T ValueAt(std::span<const uint8_t> bytes, size_t i, bool swap) {
  uint8_t raw[sizeof(T)];
  std::memcpy(raw, bytes.data() + i * sizeof(T), sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

// The values as stored: integers of at most 16 bits, or floats, so that float is exact.
template <class T>
void ReadValues(std::span<const uint8_t> bytes, bool swap, std::vector<float>& values) {
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(ValueAt<T>(bytes, i, swap));
}

void CheckFinite(const Volume& volume, const std::string& name) {
  const auto is_bad = [](float value) { return !std::isfinite(value); };
  const auto begin = volume.samples.begin(), end = volume.samples.end();
  const auto bad = std::find_if(begin, end, is_bad);
  if (bad == end) return;
  const size_t first = size_t(bad - begin), nx = size_t(volume.size.x), ny = size_t(volume.size.y);
  throw DataError(
      fmt::format("{}: {} samples are not finite, the first at ({}, {}, {}); replace them", name,
                  WithThousands(size_t(std::count_if(bad, end, is_bad))), first % nx,
                  first / nx % ny, first / nx / ny));
}

// Maps the file's values to [0, 1].
void Normalise(const glm::dvec2& range, Volume& volume) {
  volume.value_at_0 = range[0];
  volume.value_at_1 = range[1];
  for (float& sample : volume.samples) {
    const double position = volume.PositionOf(double(sample));
    volume.clamped += !(position >= 0 && position <= 1);
    sample = float(std::clamp(position, 0.0, 1.0));
  }
}

}  // namespace

size_t BytesOf(SampleType type) {
  return type == SampleType::kUint8 ? 1 : type == SampleType::kFloat32 ? 4 : 2;
}

ValueRange RangeOf(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return glm::dvec2(0, std::numeric_limits<uint8_t>::max());
    case SampleType::kUint16:
      return glm::dvec2(0, std::numeric_limits<uint16_t>::max());
    case SampleType::kInt16:
      return glm::dvec2(std::numeric_limits<int16_t>::min(), std::numeric_limits<int16_t>::max());
    case SampleType::kFloat32:
      return std::nullopt;
  }
  throw BugError("unknown sample type");
}

void VolumeLayout::Check(const std::string& name) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] < 2 || size[axis] > kMaxSide) {
      throw DataError(fmt::format("{}: {} samples along {}; expected 2 to {}", name, size[axis],
                                  "xyz"[axis], kMaxSide));
    }
    if (!(spacing[axis] >= 1e-12 && spacing[axis] <= 1e12)) {
      throw DataError(fmt::format("{}: a spacing of {} along {}; expected a number above 0", name,
                                  spacing[axis], "xyz"[axis]));
    }
    if (!(std::abs(origin[axis]) <= 1e12)) {
      throw DataError(fmt::format("{}: an origin of {} along {}; expected a finite number", name,
                                  origin[axis], "xyz"[axis]));
    }
  }
  // The count is at most 2^48 and cannot overflow.
  if (Count() > kMaxSamples) {
    throw DataError(
        fmt::format("{}: {} x {} x {} samples; expected at most {} in all, so reduce it to every "
                    "second sample",
                    name, size.x, size.y, size.z, WithThousands(kMaxSamples)));
  }
}

Volume DecodeVolume(const VolumeLayout& layout, std::span<const uint8_t> bytes,
                    const std::string& name, const ValueRange& range) {
  layout.Check(name);
  if (bytes.size() < layout.Bytes()) {
    throw DataError(fmt::format("{}: contains {} bytes of samples, but {} x {} x {} {} take {}",
                                name, WithThousands(bytes.size()), layout.size.x, layout.size.y,
                                layout.size.z, Name(layout.type), WithThousands(layout.Bytes())));
  }
  Volume volume{layout.size, layout.spacing, layout.origin};
  volume.samples.resize(layout.Count());
  const bool swap = layout.big_endian != (std::endian::native == std::endian::big);
  switch (layout.type) {
    case SampleType::kUint8:
      ReadValues<uint8_t>(bytes, swap, volume.samples);
      break;
    case SampleType::kUint16:
      ReadValues<uint16_t>(bytes, swap, volume.samples);
      break;
    case SampleType::kInt16:
      ReadValues<int16_t>(bytes, swap, volume.samples);
      break;
    case SampleType::kFloat32:
      ReadValues<float>(bytes, swap, volume.samples);
      CheckFinite(volume, name);
      break;
  }
  const auto [least, largest] = std::minmax_element(volume.samples.begin(), volume.samples.end());
  volume.least_value = *least;
  volume.largest_value = *largest;
  const ValueRange known = range ? range : RangeOf(layout.type);
  if (!known && volume.least_value == volume.largest_value) {
    throw DataError(
        fmt::format("{}: all samples are {}; the range of floating-point samples is that of their "
                    "values, so these must differ; otherwise give a value range",
                    name, volume.least_value));
  }
  Normalise(known.value_or(glm::dvec2(volume.least_value, volume.largest_value)), volume);
  return volume;
}

}  // namespace tetrec
