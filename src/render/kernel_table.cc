// A table of the time that the device spent in each kernel, for the log.
#include "render/kernel_table.h"

#include "core/log.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {

std::vector<std::string> KernelTable(const KernelReport& report) {
  std::vector<KernelTime> kernels = report.kernels;
  std::sort(kernels.begin(), kernels.end(),
            [](const KernelTime& a, const KernelTime& b) { return a.seconds > b.seconds; });
  double total = 0;
  size_t width = 6;
  for (const KernelTime& kernel : kernels) {
    total += kernel.seconds;
    width = std::max(width, kernel.name.size());
  }
  std::vector<std::string> lines = {
      fmt::format("{:<{}}  {:>10}  {:>12}  {:>6}", "kernel", width, "calls", "ms", "share")};
  for (const KernelTime& kernel : kernels) {
    lines.push_back(fmt::format("{:<{}}  {:>10}  {:>12.1f}  {:>4.1f} %", kernel.name, width,
                                WithThousands(kernel.calls), 1e3 * kernel.seconds,
                                total > 0 ? 100 * kernel.seconds / total : 0.0));
  }
  return lines;
}

void LogKernelTimes(const RendererOptions& options, const Renderer& renderer) {
  if (!options.device.time_kernels) return;
  const KernelReport report = renderer.KernelTimes();
  if (!report.has_timestamps) {
    LogInfo("kernel times: '{}' has no timestamps, nothing was timed",
            renderer.DescribeDevice()["name"].get<std::string>());
    return;
  }
  for (const std::string& line : KernelTable(report)) LogInfo("{}", line);
  if (report.untimed_calls > 0) {
    LogInfo("{} calls were not timed: the query pool grew too late",
            WithThousands(report.untimed_calls));
  }
}

}  // namespace tetrec
