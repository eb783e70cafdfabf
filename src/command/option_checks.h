// Checks of numbers on the command line. Unlike CLI11's own, they refuse NaN and state the bound in
// words.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace tetrec {

inline CLI::Validator AboveZero() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value > 0;
        return good ? std::string() : text + " is not a number above 0";
      },
      "above 0");
}

inline CLI::Validator AtLeastZero() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= 0;
        return good ? std::string() : text + " is not a number of 0 or more";
      },
      "at least 0");
}

}  // namespace tetrec
