// Text from outside as it may be shown.
#pragma once

#include <string>
#include <string_view>

namespace tetrec {

// The text, in which the bytes of control characters and those that are not UTF-8 are written as
// \x1b: what a file is named must not command a terminal.
std::string Printable(std::string_view text);

}  // namespace tetrec
