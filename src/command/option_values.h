// The values of command-line options, as a manifest records them.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace tetrec {

// The given value or the default: a number, a truth value, text, or an array of these.
nlohmann::json OptionValue(const CLI::Option& option);

// Throws UsageError for what CLI11 accepts wrongly: it reads "nan" and "inf" as numbers, wraps "-3"
// to a huge number for an unsigned option, takes the largest number for a larger one, and an empty
// text for a path.
void CheckNumbers(const CLI::App& app);

}  // namespace tetrec
