// The renderer's options on the command line of a stage.
#pragma once

#include "core/stage.h"
#include "render/renderer.h"

namespace tetrec {

// Adds --renderer, --fragment-memory, --fragment-sort and --device, which set `options`.
void AddRendererOptions(StageCommand& command, RendererOptions& options);

}  // namespace tetrec
