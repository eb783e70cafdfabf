// Many names in one message.
#pragma once

#include <string>
#include <vector>

namespace tetrec {

// "a, b, c and 7 more": the first 10.
std::string ShortList(const std::vector<std::string>& names);

}  // namespace tetrec
