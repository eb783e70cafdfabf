// The values of command-line options, as a manifest records them.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace tetrec {

// The given value, else the default: a number, a truth value, text, or an array of these.
nlohmann::json OptionValue(const CLI::Option& option);

// Throws UsageError where CLI11 was too kind: it takes "nan" and "inf" for numbers, and wraps "-3"
// where none below 0 may stand.
void CheckNumbers(const CLI::App& app);

}  // namespace tetrec
