// Log lines, and the status line that a terminal shows below them.
#include "core/log.h"

#include "core/printable.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <utility>

namespace tetrec {
namespace {

// The only process-wide state: there is one stderr and one log.txt.
struct LogState {
  std::mutex mutex;
  std::FILE* file = nullptr;
  std::string status_line;
  std::vector<std::string> warnings;
};

LogState& State() {
  static LogState* state = new LogState;  // never destroyed: threads may log until the very end
  return *state;
}

const char* Prefix(LogLevel level) {
  switch (level) {
    case LogLevel::kWarning:
      return "warning: ";
    case LogLevel::kError:
      return "error: ";
    case LogLevel::kInfo:
      break;
  }
  return "";
}

void WriteToFile(std::FILE* file, const std::string& text) {
  if (file == nullptr) return;
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char clock[16];
  std::strftime(clock, sizeof(clock), "%H:%M:%S", &parts);
  // A log on a full disk must not stop the work; whatever matters is written elsewhere.
  fmt::print(file, "{} {}\n", clock, text);
  std::fflush(file);
}

}  // namespace

void LogLine(LogLevel level, const std::string& line) {
  LogState& state = State();
  const std::scoped_lock lock(state.mutex);
  const std::string text = Prefix(level) + Printable(line);
  if (level == LogLevel::kWarning) state.warnings.push_back(line);
  if (!state.status_line.empty()) std::fputs("\r\033[K", stderr);
  std::fputs((text + "\n" + state.status_line).c_str(), stderr);
  std::fflush(stderr);
  WriteToFile(state.file, text);
}

void SetLogFile(const std::filesystem::path& path) {
  LogState& state = State();
  const std::scoped_lock lock(state.mutex);
  if (state.file != nullptr) std::fclose(state.file);
  state.file = path.empty() ? nullptr : std::fopen(path.c_str(), "ae");
}

std::vector<std::string> TakeWarnings() {
  LogState& state = State();
  const std::scoped_lock lock(state.mutex);
  return std::exchange(state.warnings, {});
}

void LogToFileOnly(const std::string& line) {
  LogState& state = State();
  const std::scoped_lock lock(state.mutex);
  WriteToFile(state.file, line);
}

void SetStatusLine(const std::string& line) {
  LogState& state = State();
  const std::scoped_lock lock(state.mutex);
  if (line.empty() && state.status_line.empty()) return;
  state.status_line = line;
  std::fputs(("\r\033[K" + line).c_str(), stderr);
  std::fflush(stderr);
}

std::string OneLine(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return Printable(text);
}

}  // namespace tetrec
