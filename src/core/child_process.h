// Runs another program by argument list (never through a shell).
#pragma once

#include "core/error.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace tetrec {

struct ChildTimedOut : EnvironmentError {
  using EnvironmentError::EnvironmentError;
};

struct ChildOptions {
  std::filesystem::path working_folder;                          // empty: ours
  std::vector<std::pair<std::string, std::string>> environment;  // added to ours
  std::filesystem::path log;                             // stdout and stderr are appended here
  std::function<void(const std::string& line)> on_line;  // called for each output line
  // Run at the same memory addresses each time (no ASLR), if the system allows it: for programs
  // whose results depend on them.
  bool fixed_addresses = false;
  uint64_t max_memory_bytes = 0;  // of its address space; 0: no limit
  double time_limit_s = 0;        // after it the child is killed (ChildTimedOut); 0: none
};

struct ChildResult {
  int exit_code = 0;  // 128 + signal if a signal ended it
  double seconds = 0;
  std::vector<std::string> last_lines;  // up to 20 lines of output, for messages
};

// Absolute path of a program in PATH; empty if there is none.
std::filesystem::path FindProgram(const std::string& name);

// Starts the program and waits for it. A request to stop ends the program too (Interrupted), and so
// does our own death. Throws EnvironmentError if the program cannot be started.
ChildResult RunChild(const std::filesystem::path& program,
                     const std::vector<std::string>& arguments, const ChildOptions& options);

}  // namespace tetrec
