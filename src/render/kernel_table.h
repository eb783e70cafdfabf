// Where the device's time went, for a log.
#pragma once

#include "render/renderer.h"

#include <string>
#include <vector>

namespace tetrec {

// A heading and a line a kernel, the longest first: name, calls, milliseconds in all, share.
std::vector<std::string> KernelTable(const KernelReport& report);

// Logs the table where RendererOptions::device.time_kernels asked for it, or why there is none.
void LogKernelTimes(const RendererOptions& options, const Renderer& renderer);

}  // namespace tetrec
