// The sizes of images in a few words.
#include "eval/sizes_in_words.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

namespace tetrec {

std::string SizesInWords(std::span<const glm::ivec2> sizes_px) {
  TETREC_CHECK(!sizes_px.empty(), "a size");
  std::map<std::pair<int, int>, size_t> counts;
  for (const glm::ivec2& size : sizes_px) ++counts[{size.x, size.y}];
  std::vector<std::pair<size_t, std::string>> by_count;
  for (const auto& [size, count] : counts) {
    by_count.push_back({count, fmt::format("{}×{}", size.first, size.second)});
  }
  std::ranges::sort(by_count, std::ranges::greater());
  if (by_count.size() == 1) return by_count[0].second + " px";
  if (by_count.size() == 2) {
    return fmt::format("{} and {} px", by_count[0].second, by_count[1].second);
  }
  return fmt::format("{} px and {} other sizes", by_count[0].second, by_count.size() - 1);
}

}  // namespace tetrec
