// The log of a run: lines to stderr and, inside a stage, to its log.txt.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

enum class LogLevel { kInfo, kWarning, kError };

// Writes one line. Thread safe. Warnings are counted and repeated at the end of a stage.
void LogLine(LogLevel level, const std::string& line);

template <class... Args>
void LogInfo(fmt::format_string<Args...> format, Args&&... args) {
  LogLine(LogLevel::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void LogWarning(fmt::format_string<Args...> format, Args&&... args) {
  LogLine(LogLevel::kWarning, fmt::format(format, std::forward<Args>(args)...));
}

// Adds (or with an empty path removes) the file that receives every line too.
void SetLogFile(const std::filesystem::path& path);
// Warnings since the last call, oldest first.
std::vector<std::string> TakeWarnings();

// For Progress: a line for the log file alone, and the line that a terminal keeps beneath the log
// (empty: none).
void LogToFileOnly(const std::string& line);
void SetStatusLine(const std::string& line);

}  // namespace tetrec
