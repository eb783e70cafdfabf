// Runs another program by argument list (never through a shell).
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace tetrec {

struct ChildOptions {
  std::filesystem::path working_folder;                          // empty: ours
  std::vector<std::pair<std::string, std::string>> environment;  // set on top of ours
  std::filesystem::path log;                             // stdout and stderr are appended here
  std::function<void(const std::string& line)> on_line;  // called for each output line
  // The same memory addresses each time (no ASLR), where the system allows it: for programs whose
  // results depend on them.
  bool fixed_addresses = false;
  double time_limit_s = 0;  // 0: none; then killed, EnvironmentError
};

struct ChildResult {
  int exit_code = 0;  // 128 + signal where a signal ended it
  double seconds = 0;
  std::vector<std::string> last_lines;  // up to 20 lines of output, for messages
};

// Absolute path of a program in PATH; empty where there is none.
std::filesystem::path FindProgram(const std::string& name);

// Starts the program, waits, and ends it when the user interrupts us (then throws Interrupted). The
// child dies with us. Throws EnvironmentError where the program cannot be started.
ChildResult RunChild(const std::filesystem::path& program,
                     const std::vector<std::string>& arguments, const ChildOptions& options);

}  // namespace tetrec
