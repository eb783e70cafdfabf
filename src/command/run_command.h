// What every program does around its work: parsing, one line per error, exit codes.
#pragma once

#include <CLI/CLI.hpp>

#include <functional>

namespace tetrec {

// Parses the command line, then runs `body`. An error becomes one line on stderr. Returns the exit
// code: this is the only place that maps errors to exit codes.
int RunCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

// Calls `check` for a struct of options. Its UsageError starts with an option's name as the struct
// or a manifest has it ("max_size is 3; expected ..."), and may quote others ('time_limit'); here
// they become the command line's: --max-size, --time-limit.
void CheckOptions(const CLI::App& app, const std::function<void()>& check);

}  // namespace tetrec
