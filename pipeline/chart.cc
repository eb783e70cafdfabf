// tetrec-chart: held-out PSNR against seconds, for one or more runs.
#include "eval/chart.h"

#include "core/plain_command.h"

#include <fmt/format.h>

namespace {

// Not a stage: it reads any number of runs, unfinished ones too, and is drawn anew each time.
void Chart(const std::vector<std::filesystem::path>& runs, const tetrec::ChartOptions& options,
           const std::filesystem::path& out) {
  std::vector<tetrec::RunCurve> curves;
  for (const std::filesystem::path& run : runs) curves.push_back(tetrec::ReadRunCurve(run));
  tetrec::WriteChart(curves, options, out);
  for (const tetrec::RunCurve& curve : curves) {
    fmt::print("{}: {:.2f} dB after {:.0f} s\n", curve.name, *curve.rows.back().heldout_psnr,
               curve.rows.back().seconds);
  }
  fmt::print("chart: {}\n", (out / "chart.svg").string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Draws held-out PSNR against seconds of optimisation, from the metrics.csv of one or more "
      "runs\n"
      "(unfinished ones too), and writes chart.svg, chart.png, chart.csv and chart.json.\n"
      "Example: tetrec-chart runs/fox runs/lego -o runs/chart",
      "tetrec-chart");
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out;
  tetrec::ChartOptions options;
  bool linear_x = false;
  app.add_option("RUN", runs, "Run folders, or folders of tetrec-optimize")->required();
  app.add_option("-o,--output", out, "Folder to write; made where it does not exist")->required();
  app.add_flag("--linear-x", linear_x, "Linear instead of logarithmic seconds");
  app.add_option("--title", options.title, "Title; default: what the runs were measured on");
  return tetrec::RunPlainCommand(app, argc, argv, [&] {
    options.log_x = !linear_x;
    Chart(runs, options, out);
  });
}
