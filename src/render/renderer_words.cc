// Renderers and their options as the command line names them.
#include "render/renderer_words.h"

#include "core/error.h"

#include <fmt/format.h>

#include <map>

namespace tetrec {
namespace {

const std::map<std::string, RendererKind> kRenderers = {{"march", RendererKind::kMarch},
                                                        {"ppll", RendererKind::kPpll},
                                                        {"projection", RendererKind::kProjection},
                                                        {"reference", RendererKind::kReference}};
const std::map<std::string, Precision> kPrecisions = {{"double", Precision::kDouble},
                                                      {"float", Precision::kFloat}};
const std::map<std::string, FragmentSort> kSorts = {
    {"auto", FragmentSort::kAuto}, {"shell", FragmentSort::kShell}, {"heap", FragmentSort::kHeap}};
const std::map<std::string, VisibilityOrder> kOrders = {{"exact", VisibilityOrder::kExact},
                                                        {"centroid", VisibilityOrder::kCentroid}};

}  // namespace

void AddRendererOptions(StageCommand& command, RendererWords& words, RendererOptions& options) {
  CLI::App& app = command.app();
  app.add_option("--renderer", words.renderer,
                 "march (from tet to tet, by far the fastest), ppll (rasterised faces in per-pixel "
                 "lists, sorted), projection (projected tets, sorted) or reference (on the CPU "
                 "without Vulkan, for small scenes); the pictures are the same")
      ->check(CLI::IsMember(&kRenderers));
  app.add_option("--precision", words.precision, "of the reference renderer: double or float")
      ->check(CLI::IsMember(&kPrecisions));
  app.add_option("--order", words.order,
                 "of projected tets: exact, or centroid (by the depth of their centroids, "
                 "approximate)")
      ->check(CLI::IsMember(&kOrders));
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
      app.add_option("--fragment-sort", words.sort,
                     "of ppll: how lists are sorted: shell, heap, or auto (by their length)")
          ->check(CLI::IsMember(&kSorts)));
  command.DoesNotChangeResults(
      app.add_flag("--time-kernels", options.device.time_kernels,
                   "ends the log with the device's time in each kernel, by timestamps"));
  command.DoesNotChangeResults(
      app.add_option("--device", options.device.device,
                     "Vulkan device: auto, cpu, gpu or a number; not of the reference"));
}

void RendererWords::Apply(RendererOptions& options) const {
  options.kind = kRenderers.at(renderer);
  options.order = kOrders.at(order);
  options.precision = kPrecisions.at(precision);
  options.integral = ParseIntegral(integral);
  options.fragment_memory = fragment_memory_mib << 20;
  options.fragment_sort = kSorts.at(sort);
  if (options.order != VisibilityOrder::kExact && options.kind != RendererKind::kProjection) {
    throw UsageError(
        fmt::format("--order {}: only --renderer projection sorts tets; leave it out", order));
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
        "--fragment-sort {}: only --renderer ppll sorts lists of fragments; leave it out", sort));
  }
  if (options.device.device != DeviceOptions().device && options.kind == RendererKind::kReference) {
    throw UsageError(
        fmt::format("--device {}: --renderer reference runs on the CPU without Vulkan; "
                    "leave it out",
                    options.device.device));
  }
  if (options.precision != Precision::kDouble && options.kind != RendererKind::kReference) {
    throw UsageError(fmt::format(
        "--precision {}: only --renderer reference has a choice; leave it out", precision));
  }
}

}  // namespace tetrec
