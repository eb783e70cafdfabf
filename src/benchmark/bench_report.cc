// Results of tetrec-bench as CSV, as a table and as charts.
#include "benchmark/bench_report.h"

#include "benchmark/stopwatch.h"
#include "core/file.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/quantile.h"
#include "core/stop_request.h"
#include "eval/plot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

double Least(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::min_element(values.begin(), values.end());
}

// The time that the second takes in addition to the first, turn by turn.
BenchTime Beyond(const BenchTime& first, const BenchTime& second) {
  BenchTime more;
  for (size_t i = 0; i < second.wall.size(); ++i) {
    more.wall.push_back(second.wall[i] - first.wall[i]);
    more.cpu.push_back(second.cpu[i] - first.cpu[i]);
  }
  return more;
}

// Millions per second; 0 if nothing was measured or a difference is not above the noise.
double Rate(double count, const std::vector<double>& milliseconds) {
  const double median = Median(milliseconds);
  return median > 0 ? 1e-3 * count / median : 0;
}

std::string Named(const BenchVariant& variant, bool with_integral) {
  std::string name = variant.renderer;
  if (!variant.order.empty()) name += ", " + variant.order + " order";
  if (with_integral) name += ", " + variant.integral;
  return name;
}

// Names and values of the CSV's columns for one case.
using Columns = std::vector<std::pair<std::string, std::string>>;

void AddTimes(Columns& columns, const std::string& name, const BenchTime& time) {
  const auto add = [&](const char* what, const std::vector<double>& values, auto pick) {
    columns.emplace_back(name + what, values.empty() ? "" : fmt::format("{:.4f}", pick(values)));
  };
  add("_wall_ms_median", time.wall, Median);
  add("_wall_ms_least", time.wall, Least);
  add("_cpu_ms_median", time.cpu, Median);
  add("_cpu_ms_least", time.cpu, Least);
}

Columns CsvColumns(const BenchRow& row) {
  const bool measured = !row.forward.wall.empty();
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  const auto if_measured = [&](double value) { return value > 0 ? number(value) : ""; };
  Columns columns = {
      {"renderer", row.variant.renderer},
      {"order", row.variant.order},
      {"integral", row.variant.integral},
      {"tets", fmt::format("{}", row.tets)},
      {"vertices", fmt::format("{}", row.vertices)},
      {"storage", Name(row.storage)},
      {"deterministic", row.variant.options.deterministic ? "1" : "0"},
      {"px", fmt::format("{}", row.size)},
      {"repetitions", fmt::format("{}", row.forward.wall.size())},
      {"skipped_at_most_s", row.skipped_seconds ? number(*row.skipped_seconds) : std::string()}};
  AddTimes(columns, "forward", row.forward);
  AddTimes(columns, "forward_backward", row.backward);
  AddTimes(columns, "forward_backward_positions", row.positions);
  const double steps = row.rays * row.steps_per_ray;
  const BenchTime backward = Beyond(row.forward, row.backward),
                  positions = Beyond(row.forward, row.positions);
  columns.insert(columns.end(),
                 {{"forward_Mrays_per_s", if_measured(Rate(row.rays, row.forward.wall))},
                  {"forward_Msteps_per_s", if_measured(Rate(steps, row.forward.wall))},
                  {"backward_Msteps_per_s", if_measured(Rate(steps, backward.wall))},
                  {"backward_positions_Msteps_per_s", if_measured(Rate(steps, positions.wall))},
                  {"steps_per_ray", if_measured(row.steps_per_ray)},
                  {"device_bytes", measured ? fmt::format("{}", row.device_bytes) : std::string()},
                  {"picture_error_largest", number(row.errors.largest)},
                  {"picture_error_rms", number(row.errors.rms)},
                  {"color_gradient_error", number(row.errors.color)},
                  {"density_gradient_error", number(row.errors.density)},
                  {"position_gradient_error",
                   row.positions.wall.empty() ? std::string() : number(row.errors.position)}});
  return columns;
}

std::string Csv(const BenchResult& result) {
  std::string csv;
  for (const BenchRow& row : result.rows) {
    std::vector<std::string> names, values;
    for (auto& [name, value] : CsvColumns(row)) {
      names.push_back(name);
      values.push_back(value);
    }
    if (csv.empty()) csv = fmt::format("{}\n", fmt::join(names, ","));
    csv += fmt::format("{}\n", fmt::join(values, ","));
  }
  return csv;
}

// Medians of wall and CPU time.
std::string TimeCell(const BenchTime& time) {
  if (time.wall.empty()) return "-";
  return fmt::format("{:.1f} / {:.1f}", Median(time.wall), Median(time.cpu));
}

std::vector<std::string> TableCells(const BenchRow& row) {
  const double steps = row.rays * row.steps_per_ray;
  const BenchTime backward = Beyond(row.forward, row.backward),
                  positions = Beyond(row.forward, row.positions);
  const auto rate = [&](double count, const BenchTime& time) {
    const double millions = Rate(count, time.wall);
    return millions > 0 ? fmt::format("{:.3g}", millions) : "-";
  };
  return {Named(row.variant, true),
          WithThousands(row.tets),
          fmt::format("{}", row.size),
          TimeCell(row.forward),
          TimeCell(backward),
          TimeCell(positions),
          rate(row.rays, row.forward),
          rate(steps, row.forward),
          rate(steps, backward),
          rate(steps, positions),
          row.steps_per_ray > 0 ? fmt::format("{:.1f}", row.steps_per_ray) : "-",
          row.device_bytes > 0 && !row.forward.wall.empty()
              ? fmt::format("{:.3g}", double(row.device_bytes) / (1 << 20))
              : "-",
          fmt::format("{:.1e}", row.errors.largest),
          fmt::format("{:.1e}", row.errors.rms),
          fmt::format("{:.0e} {:.0e}", row.errors.color, row.errors.density) +
              (row.positions.wall.empty() ? "" : fmt::format(" {:.0e}", row.errors.position)),
          row.skipped_seconds ? fmt::format("skipped: up to {:.0f} s each", *row.skipped_seconds)
                              : fmt::format("{}", row.forward.wall.size())};
}

std::string Caption(const BenchResult& result) {
  return fmt::format(
      "{}, attributes per {}; {}; gradients are summed in {}. Times are medians over the turns, "
      "wall "
      "/ CPU (all threads), in ms per image; the variants take turns on the same views. Backward "
      "is "
      "the time that a pass with gradients takes in addition to forward alone. Rates are by wall "
      "time; a step is one tet on one ray, counted by {} with the early stop at transmittance "
      "{:g}. "
      "MiB is the peak size of all buffers up to then. Errors are relative to the reference "
      "renderer "
      "in double precision with the exact integral and without early stop, on images of {} x {} px "
      "over black and white with full scale 1; gradients of colour, density and position are those "
      "of random pixel gradients, their errors relative in the norm. A case is not repeated after "
      "{:g} s, and skipped if the times of smaller cases suggest that one turn might take more "
      "than "
      "{:g} s.\n",
      result.scene, Name(result.rows[0].storage), result.device,
      result.options.renderer.deterministic ? "64-bit fixed point" : "floats",
      UsesVulkan(result.options) ? "the march" : "the reference",
      result.options.renderer.stop_transmittance, result.options.error_size,
      result.options.error_size, result.options.case_seconds, result.options.longest_turn);
}

// The largest image size at which every variant was measured on this mesh; 0 if there is none.
int CommonSize(const BenchResult& result, uint64_t tets) {
  std::map<int, bool> common;
  for (const BenchRow& row : result.rows) {
    if (row.tets != tets) continue;
    common.try_emplace(row.size, true).first->second &= !row.skipped_seconds;
  }
  int size = 0;
  for (const auto& [px, all] : common) {
    if (all) size = px;
  }
  return size;
}

double MicrosecondsPerRay(const BenchRow& row) { return 1e3 * Median(row.backward.cpu) / row.rays; }

// For one mesh: the integrals of the first renderer from mean to split:N as one curve, everything
// else as points.
Plot AccuracyPlot(const BenchResult& result) {
  uint64_t tets = 0;
  for (const BenchRow& row : result.rows) {
    if (CommonSize(result, row.tets) > 0 && (tets == 0 || row.tets <= 200'000)) tets = row.tets;
  }
  const int size = CommonSize(result, tets);
  Plot plot;
  plot.title = fmt::format("Speed against accuracy: {} tets, {} x {} px, {}", WithThousands(tets),
                           size, size, result.device);
  plot.x_label = "CPU time of forward and backward [µs per ray]";
  plot.y_label = "RMS error of the image (full scale 1)";
  plot.log_x = plot.log_y = true;
  PlotSeries splits{"", {}, {}};
  std::string from, to;
  for (const BenchRow& row : result.rows) {
    if (row.tets != tets || row.size != size || row.skipped_seconds) continue;
    const bool first = row.variant.renderer == result.rows[0].variant.renderer &&
                       row.variant.order == result.rows[0].variant.order;
    if (first && row.variant.integral != "exact") {
      splits.x.push_back(MicrosecondsPerRay(row));
      splits.y.push_back(row.errors.rms);
      if (from.empty()) from = row.variant.integral;
      to = row.variant.integral;
    } else {
      plot.series.push_back({Named(row.variant, true),
                             {MicrosecondsPerRay(row)},
                             {row.errors.rms},
                             int(plot.series.size()) + 1});
    }
  }
  if (!splits.x.empty()) {
    splits.legend = fmt::format("{}, {}", Named(result.rows[0].variant, false), from);
    if (to != from) splits.legend += " to " + to;
    plot.series.insert(plot.series.begin(), splits);
  }
  return plot;
}

// The reference has no error, and a logarithmic axis cannot show 0.
bool HasErrors(const Plot& plot) {
  return std::any_of(plot.series.begin(), plot.series.end(), [](const PlotSeries& series) {
    return std::any_of(series.y.begin(), series.y.end(), [](double error) { return error > 0; });
  });
}

// Time over the number of tets, at the largest image size at which all variants were measured on
// the smallest mesh: the last integral of every renderer, forward as a line, with backward dashed.
Plot ScalingPlot(const BenchResult& result) {
  const int size = CommonSize(result, result.rows[0].tets);
  Plot plot;
  plot.title = fmt::format("Time per image: {} x {} px, {} integral, {}", size, size,
                           result.options.integrals.back(), result.device);
  plot.x_label = "tets";
  plot.y_label = "wall time [ms]";
  plot.log_x = plot.log_y = true;
  std::vector<std::string> names;
  for (const BenchRow& row : result.rows) {
    if (row.size != size || row.skipped_seconds) continue;
    if (row.variant.integral != result.options.integrals.back()) continue;
    const std::string name = Named(row.variant, false);
    const size_t place = size_t(std::find(names.begin(), names.end(), name) - names.begin());
    if (place == names.size()) {
      names.push_back(name);
      plot.series.push_back({name, {}, {}, int(place)});
      plot.series.push_back({name + ", with backward", {}, {}, int(place)});
      plot.series.back().dashed = true;
    }
    for (PlotSeries* series : {&plot.series[2 * place], &plot.series[2 * place + 1]}) {
      const BenchTime& time = series->dashed ? row.backward : row.forward;
      series->x.push_back(double(row.tets));
      series->y.push_back(Median(time.wall));
    }
  }
  return plot;
}

}  // namespace

std::string BenchTable(const BenchResult& result) {
  std::vector<std::vector<std::string>> rows = {
      {"renderer", "tets", "px", "forward", "backward", "with positions", "Mrays/s", "Msteps/s",
       "backward", "positions", "steps/ray", "MiB", "largest error", "RMS error", "gradient errors",
       "turns"}};
  for (const BenchRow& row : result.rows) rows.push_back(TableCells(row));
  std::vector<size_t> widths(rows[0].size());
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string table = Caption(result) + "\n";
  for (size_t r = 0; r < rows.size(); ++r) {
    for (size_t c = 0; c < widths.size(); ++c) {
      table += c == 0 ? fmt::format("| {:<{}} ", rows[r][c], widths[c])
                      : fmt::format("| {:>{}} ", rows[r][c], widths[c]);
    }
    table += "|\n";
    if (r > 0) continue;
    for (size_t c = 0; c < widths.size(); ++c) {
      table += c == 0 ? fmt::format("|{:-<{}}", "", widths[c] + 2)
                      : fmt::format("|{:-<{}}:", "", widths[c] + 1);
    }
    table += "|\n";
  }
  return table;
}

void WriteBench(const BenchResult& result, const fs::path& out) {
  WriteText(out / "bench.csv", Csv(result));
  WriteText(out / "table.md", BenchTable(result));
  for (const char* chart : {"accuracy.svg", "accuracy.png", "scaling.svg", "scaling.png"}) {
    fs::remove(out / chart);  // of an earlier run
  }
  ThrowIfStopRequested("bench.csv and table.md have what was measured before");
  const fs::path scratch = out / ".gnuplot";
  const Plot accuracy = AccuracyPlot(result);
  const bool any_error = HasErrors(accuracy);
  if (!any_error) LogInfo("no accuracy chart: nothing in it has an error");
  for (const char* kind : {".svg", ".png"}) {
    if (any_error) DrawPlot(accuracy, out / (std::string("accuracy") + kind), scratch);
    DrawPlot(ScalingPlot(result), out / (std::string("scaling") + kind), scratch);
  }
  fs::remove_all(scratch);
}

}  // namespace tetrec
