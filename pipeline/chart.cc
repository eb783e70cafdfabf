// tetrec-chart: held-out PSNR over time, and size against gain, for one or more runs.
#include "eval/chart.h"

#include "command/run_command.h"

#include <fmt/format.h>

int main(int argc, char** argv) {
  CLI::App app(
      "Draws held-out PSNR over seconds of optimisation from the metrics.csv of one or more runs,\n"
      "finished or not, and writes chart.svg, chart.png, chart.csv and chart.json; from the\n"
      "growth.json of finished runs judged PSNR over tets: growth.svg and growth.png.\n"
      "Example: tetrec-chart runs/fox runs/lego -o runs/chart",
      "tetrec-chart");
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out;
  tetrec::ChartOptions options;
  bool linear_x = false;
  app.add_option("RUN", runs, "Run folders, or folders of tetrec-optimize")->required();
  app.add_option("-o,--output", out, "Folder to write; created if missing")->required();
  app.add_flag("--linear-x", linear_x, "Use a linear instead of a logarithmic time axis");
  app.add_option("--title", options.title, "Title; by default the protocol of the runs");
  return tetrec::RunCommand(app, argc, argv, [&] {
    options.log_x = !linear_x;
    for (const tetrec::RunCurve& curve : DrawChart(runs, options, out)) {
      fmt::print("{}: {:.2f} dB after {:.0f} s\n", curve.name, *curve.rows.back().heldout_psnr,
                 curve.rows.back().seconds);
    }
    fmt::print("chart: {}\n", (out / "chart.svg").string());
  });
}
