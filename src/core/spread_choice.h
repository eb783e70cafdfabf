// A few of many items, from all parts of their sequence.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace tetrec {

// `count` of the items at even distances, the first of them included; all if there are no more.
template <typename Item>
std::vector<Item> SpreadChoice(std::span<const Item> items, size_t count) {
  count = std::min(count, items.size());
  std::vector<Item> chosen;
  chosen.reserve(count);
  for (size_t i = 0; i < count; ++i) chosen.push_back(items[i * items.size() / count]);
  return chosen;
}

}  // namespace tetrec
