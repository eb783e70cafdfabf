// Renderers and their options as the command line names them.
#include "render/renderer_words.h"

#include "core/error.h"
#include "core/word_option.h"

#include <fmt/format.h>

namespace tetrec {
void AddRendererOptions(StageCommand& command, RendererWords& words, RendererOptions& options) {
  CLI::App& app = command.app();
  AddWordOption(app, "--renderer", words.renderer,
                "march (from tet to tet, by far the fastest), ppll (rasterised faces in per-pixel "
                "lists, sorted), projection (projected tets, sorted) or reference (on the CPU "
                "without Vulkan, for small scenes); the pictures are the same");
  AddWordOption(app, "--precision", words.precision, "of the reference renderer: double or float");
  AddWordOption(app, "--order", words.order,
                "of projected tets: exact, or centroid (by the depth of their centroids, "
                "approximate)");
  app.add_option(
      "--integral", words.integral,
      "colour of a ray inside a tet: exact (linear density), mean (mean density) or split:N "
      "(N = 1 .. 64 equal parts of constant density); opacity is exact in all of them");
  command.DoesNotChangeResults(
      app.add_option("--fragment-memory", words.fragment_memory_mib,
                     "of ppll and projection: what lists may take on the device [MiB]; what does "
                     "not fit is rendered a part at a time")
          ->check(CLI::Range(uint64_t(1), uint64_t(1) << 24)));
  command.DoesNotChangeResults(
      AddWordOption(app, "--fragment-sort", words.sort,
                    "of ppll: how lists are sorted: shell, heap, or auto (by their length)"));
  command.DoesNotChangeResults(
      app.add_flag("--time-kernels", options.device.time_kernels,
                   "ends the log with the device's time in each kernel, by timestamps"));
  command.DoesNotChangeResults(
      app.add_option("--device", options.device.device,
                     "Vulkan device: auto, cpu, gpu or a number; not of the reference"));
}

void RendererWords::Apply(RendererOptions& options) const {
  options.kind = renderer;
  options.order = order;
  options.precision = precision;
  options.integral = ParseIntegral(integral);
  options.fragment_memory = fragment_memory_mib << 20;
  options.fragment_sort = sort;
  if (options.order != VisibilityOrder::kExact && options.kind != RendererKind::kProjection) {
    throw UsageError(fmt::format("--order {}: only --renderer projection sorts tets; leave it out",
                                 Name(order)));
  }
  const bool has_lists =
      options.kind == RendererKind::kPpll || options.kind == RendererKind::kProjection;
  if (options.fragment_memory != RendererOptions().fragment_memory && !has_lists) {
    throw UsageError(
        fmt::format("--fragment-memory {}: only --renderer ppll and projection make lists; leave "
                    "it out",
                    fragment_memory_mib));
  }
  if (options.fragment_sort != FragmentSort::kAuto && options.kind != RendererKind::kPpll) {
    throw UsageError(fmt::format(
        "--fragment-sort {}: only --renderer ppll sorts lists of fragments; leave it out",
        Name(sort)));
  }
  if (options.device.device != DeviceOptions().device && options.kind == RendererKind::kReference) {
    throw UsageError(
        fmt::format("--device {}: --renderer reference runs on the CPU without Vulkan; "
                    "leave it out",
                    options.device.device));
  }
  if (options.precision != Precision::kDouble && options.kind != RendererKind::kReference) {
    throw UsageError(fmt::format(
        "--precision {}: only --renderer reference has a choice; leave it out", Name(precision)));
  }
}

}  // namespace tetrec
