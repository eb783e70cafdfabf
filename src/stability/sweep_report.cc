// Writes sweep.html, sweep.json, sweep.csv and the charts.
#include "stability/sweep_report.h"

#include "core/file.h"
#include "core/progress.h"
#include "eval/csv.h"
#include "eval/html.h"
#include "eval/plot.h"
#include "stability/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

struct Measure {
  const char* name;                                 // of files
  const char* label;                                // of the axis
  std::function<double(const ChainResult&)> value;  // not a number if unknown
};

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<Measure> Measures() {
  return {{"psnr", "PSNR, held-out views [dB]",
           [](const ChainResult& run) { return run.psnr.value_or(kUnknown); }},
          {"degenerate", "degenerate tets",
           [](const ChainResult& run) {
             return run.tets > 0 ? double(run.degenerate_tets) : kUnknown;
           }},
          {"seconds", "tetrec-optimize [s]", [](const ChainResult& run) { return run.seconds; }}};
}

const char* LabelOf(SweptParameter parameter) {
  switch (parameter) {
    case SweptParameter::kColorRate:
      return "rate of colour and density";
    case SweptParameter::kPositionRate:
      return "rate of positions [share of the subject's longest side]";
    case SweptParameter::kWeight:
      return "weight of the regulariser (lambda)";
    case SweptParameter::kSharpness:
      return "sharpness of the regulariser (beta)";
  }
  TETREC_CHECK(false, "a parameter of unknown kind");
}

// The curves of the methods, and crosses at the runs that broke: where they are known, else at the
// bottom.
Plot PlotOf(const std::vector<SweepResult>& results, SweptParameter parameter,
            const Measure& measure) {
  Plot plot{.title = {},
            .x_label = LabelOf(parameter),
            .y_label = measure.label,
            .y2_label = {},
            .log_x = true,
            .width_px = 460,
            .height_px = 330,
            .series = {}};
  double least = std::numeric_limits<double>::infinity();
  for (const SweepResult& result : results) {
    const double value = measure.value(result.run);
    if (result.parameter == parameter && value < least) least = value;
  }
  PlotSeries crosses{.legend = "broken", .x = {}, .y = {}, .crosses = true};
  for (const auto& [method, word] : kWords<SweptMethod>) {
    PlotSeries curve{.legend = word, .x = {}, .y = {}, .color = int(method)};
    for (const SweepResult& result : results) {
      if (result.parameter != parameter || result.method != method) continue;
      const double value = measure.value(result.run);
      curve.x.push_back(result.value);
      curve.y.push_back(value);
      if (!result.IsBroken()) continue;
      crosses.x.push_back(result.value);
      crosses.y.push_back(std::isfinite(value) ? value : std::isfinite(least) ? least : 0);
    }
    plot.series.push_back(std::move(curve));
  }
  if (!crosses.x.empty()) plot.series.push_back(std::move(crosses));
  return plot;
}

// The charts of a parameter, side by side.
std::string DrawCharts(const std::vector<SweepResult>& results, SweptParameter parameter,
                       const fs::path& out) {
  std::string html;
  for (const Measure& measure : Measures()) {
    const Plot plot = PlotOf(results, parameter, measure);
    const std::string name = fmt::format("{}-{}", Name(parameter), measure.name);
    const fs::path scratch = out / "charts" / "scratch";
    for (const char* kind : {".png", ".svg"})
      DrawPlot(plot, out / "charts" / (name + kind), scratch);
    fs::remove_all(scratch);
    html += fmt::format("<div class=\"plot\"><img src=\"{}\" alt=\"{} over {}\"></div>",
                        SvgDataUri(ReadText(out / "charts" / (name + ".svg"))), measure.label,
                        LabelOf(parameter));
  }
  return "<div class=\"plots\">" + html + "</div>";
}

std::string Table(const std::vector<SweepResult>& results) {
  std::string table = "<div class=\"scroll\"><table>";
  table += HtmlRow({"Parameter", "Method", "What the program said", "Value", "PSNR [dB]",
                    "Degenerate", "Least radius ratio", "Seconds"},
                   3, "th");
  for (const SweepResult& result : results) {
    const ChainResult& run = result.run;
    const std::string method = Name(result.method);
    table +=
        HtmlRow({Name(result.parameter),
                 result.IsBroken() ? "<span class=\"breaks\">" + method + "</span>" : method,
                 EscapeHtml(run.said), fmt::format("{:g}", result.value), Decibel(run.psnr),
                 WithThousands(run.degenerate_tets), fmt::format("{:.2g}", run.min_radius_ratio),
                 fmt::format("{:.1f}", run.seconds)},
                3);
  }
  return table + "</table></div>";
}

std::string Summary(const std::vector<SweepResult>& results) {
  std::string summary;
  for (const auto& [method, word] : kWords<SweptMethod>) {
    size_t runs = 0, broken = 0;
    for (const SweepResult& result : results) {
      runs += result.method == method;
      broken += result.method == method && result.IsBroken();
    }
    summary +=
        fmt::format("{}{}: {} of {} runs broke", summary.empty() ? "" : "; ", word, broken, runs);
  }
  const size_t unsafe = UnsafeRuns(results).size();
  return summary + fmt::format(
                       ". {} of the runs of safe motion broke or lost more than {:g} dB "
                       "against fixed vertices.",
                       unsafe, kLargestSweepLoss_db);
}

std::string Csv(const std::vector<SweepResult>& results) {
  std::string csv =
      "parameter,value,method,broken,psnr,worst_psnr,tets,degenerate_tets,min_radius_ratio,seconds,"
      "exit_code,said\n";
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4f}", *value) : "";
  };
  for (const SweepResult& result : results) {
    const ChainResult& run = result.run;
    csv += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{}\n", Name(result.parameter),
        fmt::format("{:g}", result.value), Name(result.method), result.IsBroken() ? "1" : "0",
        number(run.psnr), number(run.worst_psnr), std::to_string(run.tets),
        std::to_string(run.degenerate_tets), fmt::format("{:.3g}", run.min_radius_ratio),
        fmt::format("{:.2f}", run.seconds), std::to_string(run.exit_code), CsvCell(run.said));
  }
  return csv;
}

json JsonOf(const SweepResult& result) {
  json entry = JsonOf(result.run);
  entry["parameter"] = Name(result.parameter);
  entry["value"] = result.value;
  entry["method"] = Name(result.method);
  entry["broken"] = result.IsBroken();
  return entry;
}

}  // namespace

void WriteSweep(const std::vector<SweepResult>& results, const SweepOptions& options,
                const fs::path& out) {
  json runs = json::array();
  for (const SweepResult& result : results) runs.push_back(JsonOf(result));
  const std::string scene = options.scene.empty() ? "two synthetic balls" : options.scene.string();
  WriteJson(out / "sweep.json", {{"schema", 1},
                                 {"scene", scene},
                                 {"iterations", options.Steps()},
                                 {"grid_cells", options.GridCells()},
                                 {"runs", runs}});
  WriteText(out / "sweep.csv", Csv(results));
  std::string body = fmt::format(
      "<p class=\"verdict\">{}</p><p class=\"note\">Scene: {}; {} steps on a grid of {} cells "
      "along "
      "the longest side, not refined. A run is broken, and marked by a red cross, if it failed or "
      "left tets that are flat or inside out.</p>",
      Summary(results), EscapeHtml(scene), WithThousands(options.Steps()), options.GridCells());
  for (const auto& [parameter, word] : kWords<SweptParameter>) {
    body += fmt::format("<h2>{}</h2>", LabelOf(parameter)) + DrawCharts(results, parameter, out);
  }
  WriteText(out / "sweep.html",
            HtmlPage("Sweep over hyperparameters", body + "<h2>All runs</h2>" + Table(results)));
}

}  // namespace tetrec
