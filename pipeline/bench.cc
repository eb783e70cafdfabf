// tetrec-bench: what each renderer, order and integral costs, and how right it is.
#include "bench/bench_report.h"
#include "bench/bench_run.h"
#include "core/error.h"
#include "core/log.h"
#include "core/option_checks.h"
#include "core/plain_command.h"
#include "core/stage.h"
#include "core/word_option.h"
#include "scene/scene.h"

#include <fmt/format.h>

namespace {

// Not a stage: what is measured anew each time is never up to date.
void Bench(tetrec::BenchOptions options, const std::filesystem::path& field_folder,
           const std::filesystem::path& out) {
  options.Check();
  std::optional<tetrec::RadianceField> field;
  std::vector<tetrec::RenderView> views;
  if (!field_folder.empty()) {
    tetrec::ReadManifest(field_folder, {"optimize"});
    field = tetrec::ReadField(field_folder / "field.tetf");
    const tetrec::Scene scene =
        tetrec::ReadScene(tetrec::PreviousStage(field_folder, {"sfm", "import"}));
    for (const tetrec::View& view : scene.views) {
      views.push_back({scene.cameras[view.camera], view.cam_from_world});
    }
  } else if (options.tets.empty()) {
    options.tets = {10'000, 100'000, 1'000'000};
  }
  std::filesystem::create_directories(out);
  tetrec::BenchResult result = RunBench(options, field ? &*field : nullptr, views);
  if (field) result.scene = field_folder.string();
  fmt::print("{}", BenchTable(result));
  WriteBench(result, out);
  fmt::print("bench.csv, table.md and charts: {}\n", out.string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Renders and backpropagates with each renderer, order and integral on meshes and pictures "
      "of\n"
      "several sizes, and writes bench.csv, table.md, accuracy.svg and scaling.svg (.png): time,\n"
      "memory, errors against the reference renderer in double.\n"
      "Example: tetrec-bench -o bench --tets 10000,100000 --size 128,256",
      "tetrec-bench");
  app.option_defaults()->always_capture_default();
  std::filesystem::path field, out;
  tetrec::BenchOptions options;
  uint64_t fragment_memory_mib = options.renderer.fragment_memory >> 20;
  app.add_option("FIELD", field,
                 "Folder of tetrec-optimize; without: a soft ball in a cube, seen from outside");
  app.add_option("-o,--output", out, "Folder to write; made where it does not exist")->required();
  const auto list = [&](const char* name, auto& values, const char* help) {
    return app.add_option(name, values, help)->delimiter(',');
  };
  list("--renderer", options.renderers, "march, ppll, projection, reference")
      ->check(CLI::IsMember(tetrec::NamesOf<tetrec::RendererKind>()));
  list("--order", options.orders, "of projection: exact, centroid")
      ->check(CLI::IsMember(tetrec::NamesOf<tetrec::VisibilityOrder>()));
  list("--integral", options.integrals,
       "exact, mean, split:N; the first renderer takes all, the others the last of them");
  app.add_flag("--all-pairs", options.all_pairs, "every renderer with every integral");
  list("--tets", options.tets,
       "sizes of the meshes: the field's vertices thinned out, or middles of edges added; default: "
       "the field's own mesh, without a field 10000,100000,1000000");
  tetrec::AddWordOption(
      app, "--storage", options.storage, "auto",
      "where density and colour live: vertex, cell or auto (where the field has them, "
      "without a field vertex)");
  list("--size", options.sizes, "sides of the square pictures [px]");
  app.add_option("--repeat", options.repeat, "turns of each variant, after one to warm up");
  app.add_option("--error-size", options.error_size,
                 "side of the pictures that errors are measured on [px]");
  app.add_option("--case-seconds", options.case_seconds,
                 "what has taken so long is not repeated [s]");
  app.add_option("--longest-turn", options.longest_turn,
                 "what may take longer for one turn is left out, and said so [s]");
  app.add_option("--stop", options.renderer.stop_transmittance,
                 "rays end at this transmittance while times are measured; 0: never")
      ->check(CLI::Range(0.0, 0.5));
  app.add_option("--seed", options.seed, "of the choice of vertices and of gradients");
  app.add_option("--fragment-memory", fragment_memory_mib, "of ppll and projection [MiB]")
      ->check(CLI::Range(uint64_t(1), uint64_t(1) << 24));
  app.add_flag("--deterministic", options.renderer.deterministic,
               "gradients are summed in fixed point, the same bytes for any number of threads");
  app.add_option("--device", options.renderer.device.device,
                 "Vulkan device: auto, cpu, gpu or a number");
  return tetrec::RunPlainCommand(app, argc, argv, [&] {
    options.renderer.fragment_memory = fragment_memory_mib << 20;
    Bench(options, field, out);
  });
}
