// Scalar volumes on regular grids: what a file's header says of them, and their samples as numbers.
//
// Samples stand at the corners of the grid's cells: the first at the origin, the last at the far
// corner, so that the volume ends at its outermost samples and nothing is extrapolated. x is
// fastest.
#pragma once

#include "core/words.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

enum class SampleType { kUint8, kUint16, kInt16, kFloat32 };
template <>
inline constexpr auto kWords<SampleType> =
    std::to_array<Word<SampleType>>({{SampleType::kUint8, "uint8"},
                                     {SampleType::kUint16, "uint16"},
                                     {SampleType::kInt16, "int16"},
                                     {SampleType::kFloat32, "float32"}});

size_t BytesOf(SampleType type);

// How the samples lie in a file.
struct VolumeLayout {
  glm::ivec3 size{0};  // samples a side, at least 2
  SampleType type = SampleType::kUint8;
  bool big_endian = false;
  glm::dvec3 spacing{1.0};  // between samples, in the file's own units
  glm::dvec3 origin{0.0};   // of the first sample, in the file's own units

  size_t Count() const { return size_t(size.x) * size_t(size.y) * size_t(size.z); }
  size_t Bytes() const { return Count() * BytesOf(type); }
  // Throws DataError("<name>: ...") for sizes outside 2 to 65,536 or of more than kMaxSamples in
  // all, and for spacings that are not above 0.
  void Check(const std::string& name) const;
};

// 2^30 samples take 4 GiB as numbers, and 16 GiB shaded.
inline constexpr size_t kMaxSamples = size_t{1} << 30;

struct Volume {
  glm::ivec3 size{0};
  glm::dvec3 spacing{1.0}, origin{0.0};
  std::vector<float> samples;  // [0, 1]; z, y, x from slow to fast
  // What the file holds where a sample is 0 and 1.
  double value_at_0 = 0, value_at_1 = 1;
  // The data's own range, and how many samples lay outside of value_at_0 to value_at_1.
  double least_value = 0, largest_value = 0;
  size_t clamped = 0;

  double PositionOf(double value) const { return (value - value_at_0) / (value_at_1 - value_at_0); }

  glm::dvec3 Extent() const { return glm::dvec3(size - 1) * spacing; }
};

// The values that become 0 and 1, the first below the second; what lies outside is clamped and
// counted. None: the type's range, of float the data's own.
using ValueRange = std::optional<glm::dvec2>;

// Of integers, what the type can hold; of float nothing.
ValueRange RangeOf(SampleType type);

// Samples from the bytes that a layout describes. Throws DataError("<name>: ...") where these are
// fewer, where float samples are not finite (how many, and the first), and where all float samples
// are equal without a range that they are placed in.
Volume DecodeVolume(const VolumeLayout& layout, std::span<const uint8_t> bytes,
                    const std::string& name, const ValueRange& range = std::nullopt);

}  // namespace tetrec
