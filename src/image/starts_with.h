// Signatures, by which files of a format are recognised.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tetrec {

template <size_t N>
bool StartsWith(std::span<const uint8_t> bytes, const uint8_t (&signature)[N]) {
  return bytes.size() >= N && std::ranges::equal(bytes.first(N), signature);
}

}  // namespace tetrec
