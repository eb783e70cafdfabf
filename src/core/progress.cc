// Progress lines with the remaining time.
#include "core/progress.h"

#include "core/log.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kTerminalInterval_s = 0.1;
constexpr double kLogInterval_s = 10.0;
// What must have passed before the rest can be estimated.
constexpr double kLeastPercent = 0.5, kLeastTime_s = 1.0;

double Since(Clock::time_point time) {
  return std::chrono::duration<double>(Clock::now() - time).count();
}

size_t TerminalWidth() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col : 80u;
}

std::string ShownNumber(double value) {
  return value == std::floor(value) ? WithThousands(uint64_t(value)) : fmt::format("{:.1f}", value);
}

}  // namespace

Progress::Progress(std::string title, double total)
    : title_(std::move(title)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_),
      last_log_(start_) {}

Progress::~Progress() {
  if (line_open_) SetStatusLine("");
}

void Progress::Update(double done, const std::string& detail) {
  done = std::isfinite(done) ? std::max(done, 0.0) : 0.0;
  const bool finished = total_ > 0 && done >= total_;
  const bool show = terminal_ && (finished || !line_open_ || Since(last_) >= kTerminalInterval_s);
  const bool log = finished || Since(last_log_) >= kLogInterval_s;
  if (!show && !log) return;

  const std::string line = ProgressLine(title_, done, total_, Since(start_), detail);
  if (show) {
    SetStatusLine(line.substr(0, TerminalWidth() - 1));
    line_open_ = true;
    last_ = Clock::now();
  }
  if (log) {
    terminal_ && !finished ? LogToFileOnly(line) : LogLine(LogLevel::kInfo, line);
    last_log_ = Clock::now();
  }
}

std::string ProgressLine(const std::string& title, double done, double total, double elapsed_s,
                         const std::string& detail) {
  const bool finished = total > 0 && done >= total;
  const double percent = total > 0 ? 100 * done / total : 0;
  std::string line = title + " ";
  if (total == Progress::kShare) {
    line += fmt::format("{:.0f} %", percent);
  } else {
    line += ShownNumber(done);
    if (total > 0) line += fmt::format("/{} ({:.0f} %)", ShownNumber(total), percent);
  }
  line += "  " + AsDuration(elapsed_s);
  if (percent >= kLeastPercent && elapsed_s >= kLeastTime_s && !finished) {
    line += ", " + AsDuration(elapsed_s * (total - done) / done) + " left";
  }
  if (!detail.empty()) line += "  " + detail;
  return line;
}

std::string WithThousands(uint64_t value) {
  std::string digits = std::to_string(value);
  for (size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

std::string AsDuration(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  const auto whole = uint64_t(seconds + 0.5);
  const uint64_t h = whole / 3600, m = whole / 60 % 60, s = whole % 60;
  return h > 0 ? fmt::format("{}:{:02}:{:02}", h, m, s) : fmt::format("{}:{:02}", m, s);
}

}  // namespace tetrec
