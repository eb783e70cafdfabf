// The options of every program that renders.
#pragma once

#include "command/stage_command.h"
#include "render/renderer.h"

namespace tetrec {

// Adds --fragment-memory, in MiB.
CLI::Option* AddFragmentMemoryOption(CLI::App& app, RendererOptions& options);

// Adds --renderer, --precision, --order, --integral, --fragment-memory, --fragment-sort,
// --time-kernels and --device.
void AddRendererOptions(StageCommand& command, RendererOptions& options);

}  // namespace tetrec
