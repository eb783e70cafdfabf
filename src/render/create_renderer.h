// Makes the renderer of a kind, in whichever folder it is.
#pragma once

#include "render/probe.h"

#include <memory>

namespace tetrec {

// Throws EnvironmentError if there is no such device, or this build has no Vulkan renderers.
std::unique_ptr<TrainingRenderer> CreateRenderer(const RendererOptions& options);

// The same renderer, for tests and benchmarks.
std::unique_ptr<ProbedRenderer> CreateProbedRenderer(const RendererOptions& options);

}  // namespace tetrec
