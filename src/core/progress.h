// Progress of long work: a line that is rewritten in place on a terminal, a plain line every 10 s
// in a log.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace tetrec {

class Progress {
 public:
  // The total of work whose `done` is the share of it.
  static constexpr double kShare = 1;
  // `total` has the unit of Update's `done`; 0: unknown, no ETA.
  Progress(std::string title, double total);
  ~Progress();
  // `detail` is shown after the count, e.g. "loss 0.003  PSNR 24.8 dB  12,402 tets".
  void Update(double done, const std::string& detail = "");

 private:
  std::string title_;
  double total_;
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point start_, last_, last_log_;
};

// The line of Progress: what is done after `elapsed_s`, and the time left once that can be known:
// after a second and half a percent.
std::string ProgressLine(const std::string& title, double done, double total, double elapsed_s,
                         const std::string& detail);
// "1,234,567"
std::string WithThousands(uint64_t value);
// "1:05", "2:03:10"
std::string AsDuration(double seconds);

}  // namespace tetrec
