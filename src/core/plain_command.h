// The command line of a program that is no stage.
#pragma once

#include <CLI/CLI.hpp>

#include <functional>

namespace tetrec {

// Parses, then runs `body`; an error becomes one line on stderr. Returns the exit code.
int RunPlainCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body);

}  // namespace tetrec
