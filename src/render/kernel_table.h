// A table of the time that the device spent in each kernel, for the log.
#pragma once

#include "render/renderer.h"

#include <string>
#include <vector>

namespace tetrec {

// A heading and one line per kernel, the longest first: name, calls, total milliseconds, share.
std::vector<std::string> KernelTable(const KernelReport& report);

// Logs the table, or why there is none, if RendererOptions::device.time_kernels asks for it.
void LogKernelTimes(const RendererOptions& options, const Renderer& renderer);

}  // namespace tetrec
