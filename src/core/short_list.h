// Many names in one message.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tetrec {

// "a, b, c and 7 more": the first `most`.
std::string ShortList(const std::vector<std::string>& names, size_t most = 10);

}  // namespace tetrec
