// Layouts of volumes, and samples from their bytes.
#include "scene/volume.h"

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

template <class T>
void DecodeIntegers(std::span<const uint8_t> bytes, bool swap, Volume& volume) {
  constexpr float kRange = std::numeric_limits<T>::max();
  for (size_t i = 0; i < volume.samples.size(); ++i) {
    volume.samples[i] = float(ValueAt<T>(bytes, i, swap)) / kRange;
  }
  volume.value_at_1 = kRange;
}

void DecodeFloats(std::span<const uint8_t> bytes, bool swap, const std::string& name,
                  Volume& volume) {
  size_t not_finite = 0, first = 0;
  float min = std::numeric_limits<float>::max(), max = std::numeric_limits<float>::lowest();
  for (size_t i = 0; i < volume.samples.size(); ++i) {
    const float value = ValueAt<float>(bytes, i, swap);
    if (!std::isfinite(value)) {
      if (not_finite++ == 0) first = i;
      continue;
    }
    min = std::min(min, value);
    max = std::max(max, value);
    volume.samples[i] = value;
  }
  if (not_finite > 0) {
    const size_t nx = size_t(volume.size.x), ny = size_t(volume.size.y);
    throw DataError(
        fmt::format("{}: {} samples are not finite, the first at ({}, {}, {}); replace them", name,
                    WithThousands(not_finite), first % nx, first / nx % ny, first / nx / ny));
  }
  if (!(min < max)) {
    throw DataError(fmt::format(
        "{}: all samples are {}; floating-point samples are taken from their least to their "
        "largest value, so these must differ",
        name, min));
  }
  volume.value_at_0 = min;
  volume.value_at_1 = max;
  const double scale = 1 / (double(max) - double(min));
  for (float& sample : volume.samples) sample = float((double(sample) - double(min)) * scale);
}

}  // namespace

const char* Name(SampleType type) {
  switch (type) {
    case SampleType::kUint8:
      return "uint8";
    case SampleType::kUint16:
      return "uint16";
    case SampleType::kFloat32:
      return "float32";
  }
  throw BugError("unknown sample type");
}

size_t BytesOf(SampleType type) {
  return type == SampleType::kUint8 ? 1 : type == SampleType::kUint16 ? 2 : 4;
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
  // At most 2^48: no overflow.
  if (Count() > kMaxSamples) {
    throw DataError(
        fmt::format("{}: {} x {} x {} samples; at most {} in all are read, so take "
                    "every second one",
                    name, size.x, size.y, size.z, WithThousands(kMaxSamples)));
  }
}

Volume DecodeVolume(const VolumeLayout& layout, std::span<const uint8_t> bytes,
                    const std::string& name) {
  layout.Check(name);
  if (bytes.size() < layout.Bytes()) {
    throw DataError(fmt::format("{}: holds {} bytes of samples where {} x {} x {} {} take {}", name,
                                WithThousands(bytes.size()), layout.size.x, layout.size.y,
                                layout.size.z, Name(layout.type), WithThousands(layout.Bytes())));
  }
  Volume volume{layout.size, layout.spacing, layout.origin};
  volume.samples.resize(layout.Count());
  const bool swap = layout.big_endian != (std::endian::native == std::endian::big);
  switch (layout.type) {
    case SampleType::kUint8:
      DecodeIntegers<uint8_t>(bytes, swap, volume);
      break;
    case SampleType::kUint16:
      DecodeIntegers<uint16_t>(bytes, swap, volume);
      break;
    case SampleType::kFloat32:
      DecodeFloats(bytes, swap, name, volume);
      break;
  }
  return volume;
}

}  // namespace tetrec
