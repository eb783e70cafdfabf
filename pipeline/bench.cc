// tetrec-bench: speed, memory and accuracy of each renderer, order and integral.
#include "benchmark/bench_report.h"
#include "benchmark/bench_run.h"
#include "command/run_command.h"
#include "command/word_option.h"
#include "core/stop_request.h"
#include "renderer_options.h"

#include <fmt/format.h>

int main(int argc, char** argv) {
  CLI::App app(
      "Renders and backpropagates with each renderer, order and integral on meshes and images of\n"
      "several sizes, and writes time, memory and errors relative to the reference renderer in\n"
      "double precision to bench.csv, table.md, accuracy.svg and scaling.svg (.png).\n"
      "Example: tetrec-bench -o bench --tets 10000,100000 --size 128,256",
      "tetrec-bench");
  app.option_defaults()->always_capture_default();
  std::filesystem::path field, out;
  tetrec::BenchOptions options;
  app.add_option("FIELD", field,
                 "Folder of tetrec-optimize; by default a soft ball in a cube, seen from outside");
  app.add_option("-o,--output", out, "Folder to write; created if missing")->required();
  const auto list = [&](const char* name, auto& values, const char* help) {
    return app.add_option(name, values, help)->delimiter(',');
  };
  list("--renderer", options.renderers, "Renderers: march, ppll, projection, reference")
      ->check(CLI::IsMember(tetrec::NamesOf<tetrec::RendererKind>()));
  list("--order", options.orders, "Visibility order of projection: exact, centroid")
      ->check(CLI::IsMember(tetrec::NamesOf<tetrec::VisibilityOrder>()));
  list("--integral", options.integrals,
       "Integrals: exact, mean, split:N; the first renderer uses all of them, the others the last");
  app.add_flag("--all-pairs", options.all_pairs, "Use every integral with every renderer");
  list(
      "--tets", options.tets,
      "Numbers of tets, reached by dropping vertices of the field or adding midpoints of edges; by "
      "default the field's own mesh, or 10000,100000,1000000 without a field");
  tetrec::AddWordOption(
      app, "--storage", options.storage, "auto",
      "Where density and colour are stored: vertex, cell or auto (as in the field; vertex without "
      "a field)");
  list("--size", options.sizes, "Side lengths of the square images [px]");
  app.add_option("--repeat", options.repeat, "Turns of each variant, after one that warms up");
  app.add_option("--error-size", options.error_size,
                 "Side length of the images that errors are measured on [px]");
  app.add_option("--case-seconds", options.case_seconds,
                 "Time after which a case is not repeated [s]");
  app.add_option("--longest-turn", options.longest_turn,
                 "Skip cases of which one turn might take longer, and mark them in the table [s]");
  app.add_option("--stop", options.renderer.stop_transmittance,
                 "Transmittance at which rays stop while times are measured; 0: never")
      ->check(CLI::Range(0.0, 0.5));
  app.add_option("--seed", options.seed,
                 "Random seed for the choice of vertices and for gradients");
  tetrec::AddFragmentMemoryOption(app, options.renderer);
  app.add_flag("--deterministic", options.renderer.deterministic,
               "Sum gradients in fixed point: the same bytes for any number of threads");
  app.add_option("--device", options.renderer.device.device,
                 "Vulkan device: auto, cpu, gpu or a number");
  return tetrec::RunCommand(app, argc, argv, [&] {
    tetrec::CheckOptions(app, [&] { options.Check(); });
    tetrec::CatchStopSignals();
    std::filesystem::create_directories(out);
    const tetrec::BenchResult result = RunBench(options, field);
    WriteBench(result, out);
    fmt::print("{}", BenchTable(result));
    fmt::print("bench.csv, table.md and charts: {}\n", out.string());
  });
}
