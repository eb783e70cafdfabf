// Errors by who can fix them. Only RunCommand maps them to exit codes.
#pragma once

#include <stdexcept>
#include <string>

namespace tetrec {

// The message is one line: what is wrong, the value, where, what to do.
class Error : public std::runtime_error {
 public:
  Error(const std::string& message, int exit_code)
      : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

// Wrong command line: exit code 2.
struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(message, 2) {}
};
// Bad input data: exit code 3.
struct DataError : Error {
  explicit DataError(const std::string& message) : Error(message, 3) {}
};
// Missing device, program or disk space: exit code 4.
struct EnvironmentError : Error {
  explicit EnvironmentError(const std::string& message) : Error(message, 4) {}
};
// The user asked to stop; work so far is in a checkpoint or untouched: exit code 130.
struct Interrupted : Error {
  explicit Interrupted(const std::string& message) : Error(message, 130) {}
};
// A bug: exit code 1.
struct BugError : Error {
  explicit BugError(const std::string& message) : Error(message, 1) {}
};

namespace internal {
[[noreturn]] void FailCheck(const char* condition, const char* file, int line,
                            const std::string& message);
}

}  // namespace tetrec

// For bugs, checked in every build type: TETREC_CHECK(i < n, fmt::format("tet {} of {}", i,
// n)).
#define TETREC_CHECK(condition, message)                                        \
  do {                                                                          \
    if (!(condition)) {                                                         \
      ::tetrec::internal::FailCheck(#condition, __FILE__, __LINE__, (message)); \
    }                                                                           \
  } while (false)
