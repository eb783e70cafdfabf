// The reference renderer behind the interface of all renderers.
#pragma once

#include "render/probe.h"

#include <memory>

namespace tetrec {

// A renderer that learns, in the precision of `options`; it touches no Vulkan.
std::unique_ptr<ProbedRenderer> CreateReferenceRenderer(const RendererOptions& options);

}  // namespace tetrec
