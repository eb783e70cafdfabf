// The options of every program that renders.
#include "renderer_options.h"

#include "command/help.h"
#include "command/word_option.h"

#include <string>

namespace tetrec {

CLI::Option* AddFragmentMemoryOption(CLI::App& app, RendererOptions& options) {
  return app
      .add_option_function<uint64_t>(
          "--fragment-memory", [&options](uint64_t mib) { options.fragment_memory = mib << 20; },
          "ppll, projection: device memory for lists [MiB]; images that need more are rendered in "
          "parts")
      ->check(CLI::Range(uint64_t(1), uint64_t(1) << 24))
      ->default_str(std::to_string(options.fragment_memory >> 20));
}

void AddRendererOptions(StageCommand& command, RendererOptions& options) {
  CLI::App& app = command.app();
  AddWordOption(
      app, "--renderer", options.kind,
      "Renderer: march (from tet to tet, by far the fastest), ppll (rasterised faces in sorted "
      "per-pixel lists), projection (projected tets, sorted) or reference (on the CPU, "
      "without Vulkan, for small scenes); all give the same images");
  AddWordOption(app, "--precision", options.precision, "reference: double or float");
  AddWordOption(app, "--order", options.order,
                "projection: exact, or centroid (tets sorted by the depth of their centroids, "
                "approximate)");
  AddParsedOption(
      app, "--integral", options.integral, ParseIntegral, Name(options.integral),
      "Colour of a ray inside a tet: exact (linear density), mean (mean density) or split:N "
      "(N = 1 .. 64 equal parts of constant density); opacity is exact in all of them");
  command.DoesNotChangeResults(AddFragmentMemoryOption(app, options));
  command.DoesNotChangeResults(
      AddWordOption(app, "--fragment-sort", options.fragment_sort,
                    "ppll: how lists are sorted: shell, heap, or auto (by their length)"));
  command.DoesNotChangeResults(
      app.add_flag("--time-kernels", options.device.time_kernels,
                   "Log the device time of each kernel at the end (by timestamps)"));
  app.add_option("--device", options.device.device,
                 "Vulkan device: auto, cpu, gpu or a number; not for the reference renderer");
  GroupOptions(app, "Renderer",
               {"--renderer", "--precision", "--order", "--integral", "--fragment-memory",
                "--fragment-sort", "--time-kernels", "--device"});
}

}  // namespace tetrec
