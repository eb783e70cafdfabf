// Renderers and their options as the command line names them.
#pragma once

#include "core/stage.h"
#include "render/renderer.h"

#include <string>

namespace tetrec {

// What the command line gives as words.
struct RendererWords {
  RendererKind renderer = RendererKind::kMarch;
  VisibilityOrder order = VisibilityOrder::kExact;
  FragmentSort sort = FragmentSort::kAuto;
  Precision precision = Precision::kDouble;
  std::string integral = "exact";
  uint64_t fragment_memory_mib = 512;

  // Throws UsageError where the words do not go together.
  void Apply(RendererOptions& options) const;
};

// The options that every stage that renders has: --renderer, --precision, --order,
// --integral, --fragment-memory, --fragment-sort, --time-kernels, --device.
void AddRendererOptions(StageCommand& command, RendererWords& words, RendererOptions& options);

}  // namespace tetrec
