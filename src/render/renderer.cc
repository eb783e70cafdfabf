// The options of the renderers.
#include "render/renderer.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {

void RendererOptions::AcceptInvertedTets() {
  constexpr uint32_t kMostSteps = 1u << 12;
  orientations = Orientations::kAny;
  max_steps = std::min(max_steps, kMostSteps);
}

void RendererOptions::Check() const {
  const auto refuse_if = [](bool wrong, const std::string& option, const char* why) {
    if (wrong) throw UsageError(fmt::format("{}: {}; leave it out", option, why));
  };
  const RendererOptions defaults;
  const bool has_lists = kind == RendererKind::kPpll || kind == RendererKind::kProjection;
  refuse_if(order != defaults.order && kind != RendererKind::kProjection,
            fmt::format("order {}", Name(order)), "only the renderer projection sorts tets");
  refuse_if(fragment_memory != defaults.fragment_memory && !has_lists,
            fmt::format("fragment-memory {}", fragment_memory >> 20),
            "only the renderers ppll and projection make lists");
  refuse_if(fragment_sort != defaults.fragment_sort && kind != RendererKind::kPpll,
            fmt::format("fragment-sort {}", Name(fragment_sort)),
            "only the renderer ppll sorts lists of fragments");
  refuse_if(device.device != defaults.device.device && kind == RendererKind::kReference,
            fmt::format("device {}", device.device),
            "the renderer reference runs on the CPU without Vulkan");
  refuse_if(precision != defaults.precision && kind != RendererKind::kReference,
            fmt::format("precision {}", Name(precision)),
            "only the renderer reference offers a choice");
}

}  // namespace tetrec
