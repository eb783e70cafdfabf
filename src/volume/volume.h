// Scalar volumes on regular grids: the layout that a file's header describes, and samples as
// numbers.
//
// Samples are at the corners of the grid's cells, the first at the origin and the last at the far
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

// How the samples are stored in a file.
struct VolumeLayout {
  glm::ivec3 size{0};  // samples along each side, at least 2
  SampleType type = SampleType::kUint8;
  bool big_endian = false;
  glm::dvec3 spacing{1.0};  // between samples, in the file's own units
  glm::dvec3 origin{0.0};   // of the first sample, in the file's own units

  size_t Count() const { return size_t(size.x) * size_t(size.y) * size_t(size.z); }
  size_t Bytes() const { return Count() * BytesOf(type); }
  // Throws DataError("<name>: ...") for sizes outside 2 to 65,536, for more than kMaxSamples in
  // all, and for spacings that are not above 0.
  void Check(const std::string& name) const;
};

// 2^30 samples take 4 GiB as numbers and another 16 GiB shaded.
inline constexpr size_t kMaxSamples = size_t{1} << 30;

struct Volume {
  glm::ivec3 size{0};
  glm::dvec3 spacing{1.0}, origin{0.0};
  std::vector<float> samples;  // [0, 1]; z, y, x from slow to fast
  // The values in the file that became samples of 0 and 1.
  double value_at_0 = 0, value_at_1 = 1;
  // The range of the data, and the number of samples that were outside value_at_0 to value_at_1.
  double least_value = 0, largest_value = 0;
  size_t clamped = 0;

  double PositionOf(double value) const { return (value - value_at_0) / (value_at_1 - value_at_0); }

  glm::dvec3 Extent() const { return glm::dvec3(size - 1) * spacing; }
};

// The values that become 0 and 1, the first below the second; samples outside are clamped and
// counted. Unset: the range of an integer type, for float that of the data.
using ValueRange = std::optional<glm::dvec2>;

// The range of an integer type; unset for float.
ValueRange RangeOf(SampleType type);

// Decodes the bytes that a layout describes. Throws DataError("<name>: ...") if there are too few,
// if float samples are not finite (with their number and the first), and if all float samples are
// equal and no range is given.
Volume DecodeVolume(const VolumeLayout& layout, std::span<const uint8_t> bytes,
                    const std::string& name, const ValueRange& range = std::nullopt);

}  // namespace tetrec
