// The log of a run: lines to stderr and, inside a stage, to its log.txt.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

enum class LogLevel { kInfo, kWarning, kError };

// Writes one line, made printable (printable.h). Thread safe. Warnings are counted and repeated at
// the end of a stage.
void LogLine(LogLevel level, const std::string& line);

template <class... Args>
void LogInfo(fmt::format_string<Args...> format, Args&&... args) {
  LogLine(LogLevel::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void LogWarning(fmt::format_string<Args...> format, Args&&... args) {
  LogLine(LogLevel::kWarning, fmt::format(format, std::forward<Args>(args)...));
}

// Sets the file that receives every line too; none if the path is empty.
void SetLogFile(const std::filesystem::path& path);
// Warnings since the last call, oldest first.
std::vector<std::string> TakeWarnings();

// The text on one line, without white space at its end, printable.
std::string OneLine(std::string text);

// For Progress: a line for the log file only, and the line that a terminal keeps below the log
// (empty: none).
void LogToFileOnly(const std::string& line);
void SetStatusLine(const std::string& line);

}  // namespace tetrec
