// Long lists of names in messages.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tetrec {

// "a, b, c and 7 more": the first `most` names and the number of the others.
std::string ShortList(const std::vector<std::string>& names, size_t most = 10);

}  // namespace tetrec
