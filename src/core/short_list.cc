// Long lists of names in messages.
#include "core/short_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tetrec {

std::string ShortList(const std::vector<std::string>& names, size_t most) {
  const size_t shown = std::min(names.size(), most);
  const auto end = names.begin() + std::ptrdiff_t(shown);
  const std::string text = fmt::format("{}", fmt::join(names.begin(), end, ", "));
  return names.size() > shown ? text + fmt::format(" and {} more", names.size() - shown) : text;
}

}  // namespace tetrec
