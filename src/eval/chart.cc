// Reads what the runs recorded, and draws them into one chart of each kind.
#include "eval/chart.h"

#include "core/error.h"
#include "core/file.h"
#include "eval/csv.h"
#include "eval/growth_plot.h"
#include "eval/plot.h"
#include "eval/run_facts.h"
#include "eval/sizes_in_words.h"
#include "scene/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// A folder that nobody else has, until the end of its life.
class NewFolder {
 public:
  // `pattern` ends in XXXXXX, which are replaced.
  explicit NewFolder(const fs::path& pattern) {
    std::string name = pattern.string();
    if (mkdtemp(name.data()) == nullptr) {
      throw EnvironmentError(
          fmt::format("{}: cannot be created ({})", pattern.string(), std::strerror(errno)));
    }
    path_ = name;
  }
  ~NewFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// What the numbers were measured on, as far as the folder records it; a run that has not finished
// has no manifest yet.
std::string ProtocolOf(const fs::path& field_folder) {
  if (!fs::exists(field_folder / "manifest.json")) return "unfinished run";
  const RunFacts facts = ReadRunFacts(field_folder);
  std::vector<std::string> parts;
  if (const StageFacts* stage = facts.Scene()) {
    const Scene scene = ReadScene(stage->folder);
    std::vector<glm::ivec2> sizes;
    for (const View& view : scene.views) {
      const Camera& camera = scene.cameras[size_t(view.camera)];
      sizes.push_back({camera.width, camera.height});
    }
    parts = {WatchedViewsInWords(facts.stages.back()), SizesInWords(sizes),
             fmt::format("background {}", Name(scene.background))};
  }
  if (const std::string device = facts.stages.back().Device(); !device.empty()) {
    parts.push_back(device);
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

// States the protocol once if all runs share it; otherwise the legend states it for each run.
std::string TitleOf(const std::vector<RunCurve>& runs) {
  const bool same = std::all_of(runs.begin(), runs.end(), [&](const RunCurve& run) {
    return run.protocol == runs.front().protocol;
  });
  if (same && !runs.front().protocol.empty()) return "Held-out PSNR: " + runs.front().protocol;
  return "Held-out PSNR (protocols differ, see the legend)";
}

// The names of the runs, or their folders if several have the same name.
std::vector<std::string> LegendsOf(const std::vector<RunCurve>& runs, bool with_protocol) {
  std::vector<std::string> legends;
  for (const RunCurve& run : runs) {
    const auto same_name = std::count_if(runs.begin(), runs.end(),
                                         [&](const RunCurve& r) { return r.name == run.name; });
    std::string legend = same_name > 1 ? run.metrics_csv.parent_path().string() : run.name;
    if (with_protocol && !run.protocol.empty()) legend += " (" + run.protocol + ")";
    legends.push_back(std::move(legend));
  }
  return legends;
}

// What of an earlier chart is in the folder goes, too.
void DrawGrowth(const std::vector<RunCurve>& runs, const std::vector<std::string>& legends,
                const fs::path& out, const fs::path& scratch) {
  std::vector<GrowthCurve> curves;
  for (size_t i = 0; i < runs.size(); ++i) curves.push_back({legends[i], runs[i].growth});
  const std::optional<Plot> plot = GrowthPlot(curves);
  for (const char* name : {"growth.svg", "growth.png"}) {
    std::error_code ignored;
    fs::remove(out / name, ignored);
    if (plot) DrawPlot(*plot, out / name, scratch);
  }
}

// [tets, judged PSNR, standard error of its gain] of each mesh that was judged.
nlohmann::json JudgedSizes(const std::vector<GrowthStep>& growth) {
  nlohmann::json sizes = nlohmann::json::array();
  for (const GrowthStep& step : growth) {
    if (step.psnr > 0) sizes.push_back({step.tets, step.psnr, step.gain_standard_error});
  }
  return sizes;
}

}  // namespace

RunCurve ReadRunCurve(const fs::path& run) {
  const fs::path folder = fs::exists(run / "3_field") ? run / "3_field" : run;
  const fs::path absolute = fs::absolute(folder / "").lexically_normal().parent_path();
  RunCurve curve;
  curve.metrics_csv = folder / kTrainingLogFile;
  if (!fs::exists(curve.metrics_csv)) {
    throw DataError(fmt::format(
        "{}: no metrics.csv here or in 3_field; give a run folder or the output of tetrec-optimize",
        run.string()));
  }
  // A folder 3_field is named after its run.
  curve.name = absolute.filename() == "3_field" ? absolute.parent_path().filename().string()
                                                : absolute.filename().string();
  curve.protocol = ProtocolOf(folder);
  curve.rows = ReadTrainingLog(curve.metrics_csv);
  std::erase_if(curve.rows, [](const TrainingRow& row) {
    return !row.heldout_psnr || !std::isfinite(*row.heldout_psnr) || !std::isfinite(row.seconds);
  });
  if (curve.rows.empty()) {
    throw DataError(
        fmt::format("{}: no row has a held-out PSNR; let tetrec-optimize watch at least one view",
                    curve.metrics_csv.string()));
  }
  if (fs::exists(folder / kMeshGrowthFile)) {
    curve.growth = ReadMeshGrowth(folder / kMeshGrowthFile);
  }
  return curve;
}

void WriteChart(const std::vector<RunCurve>& runs, const ChartOptions& options,
                const fs::path& out) {
  TETREC_CHECK(!runs.empty(), "a chart needs runs");
  Plot plot;
  plot.title = options.title.empty() ? TitleOf(runs) : options.title;
  plot.x_label = options.log_x ? "seconds of optimisation (log)" : "seconds of optimisation";
  plot.y_label = "held-out PSNR [dB]";
  plot.log_x = options.log_x;
  const bool protocols_differ = std::any_of(runs.begin(), runs.end(), [&](const RunCurve& run) {
    return run.protocol != runs.front().protocol;
  });
  const std::vector<std::string> legends = LegendsOf(runs, protocols_differ);

  std::string csv = "run,iteration,seconds,heldout_psnr,tets,vertices\n";
  nlohmann::json record = {{"schema", 1},
                           {"title", plot.title},
                           {"log_x", options.log_x},
                           {"runs", nlohmann::json::array()}};
  for (size_t i = 0; i < runs.size(); ++i) {
    PlotSeries series;
    series.legend = legends[i];
    series.color = int(i);
    nlohmann::json points = nlohmann::json::array();
    double best = runs[i].rows.front().heldout_psnr.value();
    for (const TrainingRow& row : runs[i].rows) {
      series.x.push_back(row.seconds);
      series.y.push_back(*row.heldout_psnr);
      best = std::max(best, *row.heldout_psnr);
      csv += fmt::format("{},{},{},{},{},{}\n", CsvCell(legends[i]), row.iteration, row.seconds,
                         *row.heldout_psnr, row.tets, row.vertices);
      points.push_back({row.seconds, *row.heldout_psnr});
    }
    record["runs"].push_back({{"name", legends[i]},
                              {"metrics_csv", runs[i].metrics_csv.generic_string()},
                              {"protocol", runs[i].protocol},
                              {"last_psnr", *runs[i].rows.back().heldout_psnr},
                              {"best_psnr", best},
                              {"seconds", runs[i].rows.back().seconds},
                              {"tets", double(runs[i].rows.back().tets)},
                              {"seconds_and_heldout_psnr", std::move(points)},
                              {"tets_judged_psnr_and_error", JudgedSizes(runs[i].growth)}});
    plot.series.push_back(std::move(series));
  }

  std::error_code error;
  fs::create_directories(out, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be created ({})", out.string(), error.message()));
  }
  const NewFolder scratch(out / ".tetrec-chart-XXXXXX");
  DrawPlot(plot, out / "chart.svg", scratch.path());
  DrawPlot(plot, out / "chart.png", scratch.path());
  DrawGrowth(runs, legends, out, scratch.path());
  WriteText(out / "chart.csv", csv);
  WriteJson(out / "chart.json", record);
}

std::vector<RunCurve> DrawChart(const std::vector<fs::path>& runs, const ChartOptions& options,
                                const fs::path& out) {
  std::vector<RunCurve> curves;
  for (const fs::path& run : runs) curves.push_back(ReadRunCurve(run));
  WriteChart(curves, options, out);
  return curves;
}

}  // namespace tetrec
