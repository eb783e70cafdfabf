// Checks of the command line. Those of numbers refuse NaN, unlike CLI11's own, and state the bound
// in words.
#pragma once

#include "core/error.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <initializer_list>
#include <string>

namespace tetrec {

// Throws UsageError if one of these options was given: "--frames: WHY".
inline void RefuseOptions(const CLI::App& app, std::initializer_list<const char*> names,
                          const std::string& why) {
  for (const char* name : names) {
    if (app.get_option(name)->count() == 0) continue;
    throw UsageError(fmt::format("{}: {}", name, why));
  }
}

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
