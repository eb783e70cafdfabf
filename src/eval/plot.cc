// Writes a gnuplot script and data files, and runs gnuplot on them.
#include "eval/plot.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <sstream>
#include <string_view>

namespace tetrec {
namespace {

// Okabe and Ito 2008, "Color universal design", without the yellow that vanishes on white; dash
// patterns and marks differ too, for print.
constexpr const char* kPalette[8] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                     "#E69F00", "#56B4E9", "#000000", "#7F7F7F"};
constexpr int kMarks[8] = {7, 5, 9, 11, 13, 6, 4, 8};

// A gnuplot string in which whatever could end it, or run a command, is an octal escape. (gnuplot
// reads single quotes at the start of a single-quoted string as its end.)
std::string Quoted(const std::string& text) {
  constexpr std::string_view kPlain = " .,:;()[]{}<>=+-*/_!?#&|~%";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = uint8_t(c);
    const bool plain = byte >= 0x80 || std::isalnum(byte) || kPlain.find(c) != kPlain.npos;
    if (byte < 0x20 || byte == 0x7f) {
      quoted += ' ';
    } else {
      quoted += plain ? std::string(1, c) : fmt::format("\\{:03o}", byte);
    }
  }
  return quoted + "\"";
}

// gnuplot cuts a title that is wider than the chart off. This breaks it between words into lines,
// as a gnuplot expression.
std::string TitleInLines(const Plot& plot) {
  constexpr double kWidestLetter_px = 8.5;  // mean width in most texts, at gnuplot's 14 pixels
  const auto room = size_t(plot.width_px / kWidestLetter_px);
  std::istringstream words(plot.title);
  std::vector<std::string> lines(1);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > room) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  for (std::string& line : lines) line = Quoted(line);
  return fmt::format("{}", fmt::join(lines, " . \"\\n\" . "));
}

std::string DataName(size_t series) { return fmt::format("series_{}.txt", series); }

// Subnormal numbers have one too, but gnuplot cannot draw it.
bool HasLogarithm(double value) { return value > 0 && std::isnormal(value); }

// The points that can be drawn; a blank line breaks the curve.
std::string DataOf(const Plot& plot, const PlotSeries& series) {
  std::string lines;
  const bool log_y = series.on_second_axis ? plot.log_y2 : plot.log_y;
  for (size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    const double x = series.x[i], y = series.y[i];
    const bool drawable = std::isfinite(x) && std::isfinite(y) &&
                          (!plot.log_x || HasLogarithm(x)) && (!log_y || HasLogarithm(y));
    lines += drawable ? fmt::format("{} {}\n", x, y) : "\n";
  }
  return lines;
}

bool HasPoints(const std::string& data) {
  return data.find_first_not_of('\n') != std::string::npos;
}

std::string Curve(const PlotSeries& series, size_t index) {
  if (series.crosses) {
    return fmt::format("'{}' using 1:2 with points lc rgb '#C00000' lw 2 pt 2 ps 1.3 title {}",
                       DataName(index), Quoted(series.legend));
  }
  const int color = series.color % 8;
  return fmt::format("'{}' using 1:2 {} with {} lc rgb '{}' lw 2 dt {} pt {} ps {} title {}",
                     DataName(index), series.on_second_axis ? "axes x1y2" : "axes x1y1",
                     series.marks ? "linespoints" : "lines", kPalette[color],
                     series.on_second_axis || series.dashed ? 2 : 1, kMarks[color],
                     series.x.size() == 1 ? 1.2 : 0.5, Quoted(series.legend));
}

// 1, 2 and 5 times the powers of ten around the data: gnuplot labels only the powers. Over more
// than three decades the powers are enough.
std::string LogTics(const Plot& plot) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const PlotSeries& series : plot.series) {
    for (const double x : series.x) {
      if (!HasLogarithm(x)) continue;
      low = std::min(low, x);
      high = std::max(high, x);
    }
  }
  constexpr int kMostDecades = 30;  // more could not be read
  const int last = int(std::ceil(std::log10(high)));
  const int first = std::max(int(std::floor(std::log10(low))), last - kMostDecades);
  std::vector<std::string> tics;
  for (int power = first; power < last; ++power) {
    for (const int factor : {1, 2, 5}) {
      if (factor == 1 || last - first <= 3) tics.push_back(fmt::format("{}e{}", factor, power));
    }
  }
  tics.push_back(fmt::format("1e{}", last));
  return fmt::format("{}", fmt::join(tics, ", "));
}

std::string Script(const Plot& plot, const std::vector<std::string>& curves, bool svg) {
  std::string script;
  const auto line = [&](const std::string& text) { script += text + "\n"; };
  line(fmt::format("set terminal {} size {},{} noenhanced font 'sans,{}' background rgb 'white'",
                   svg ? "svg" : "pngcairo", plot.width_px, plot.height_px, svg ? 14 : 11));
  line(svg ? "set output 'chart.svg'" : "set output 'chart.png'");
  line("set encoding utf8");
  line("set autoscale xfix\nset offsets graph 0.02, graph 0.02, graph 0.04, graph 0.04");
  line("set border 3 lc rgb '#888888'\nset tics nomirror textcolor rgb '#333333'");
  line("set grid xtics ytics lc rgb '#dddddd' lw 1 lt 1");
  line("set key outside top center horizontal noenhanced textcolor rgb '#333333'");
  line("set title " + TitleInLines(plot) + " noenhanced textcolor rgb '#222222'");
  line("set xlabel " + Quoted(plot.x_label) + "\nset ylabel " + Quoted(plot.y_label));
  if (plot.log_x) line("set logscale x\nset format x '%g'\nset xtics (" + LogTics(plot) + ")");
  if (plot.log_y) line("set logscale y\nset format y '%.0e'");
  const bool second = std::any_of(plot.series.begin(), plot.series.end(),
                                  [](const PlotSeries& s) { return s.on_second_axis; });
  if (second) {
    line("set border 11\nset y2tics\nset y2label " + Quoted(plot.y2_label));
    if (plot.log_y2) line("set logscale y2");
  }
  line("plot " + fmt::format("{}", fmt::join(curves, ", ")));
  return script;
}

}  // namespace

void DrawPlot(const Plot& plot, const std::filesystem::path& out,
              const std::filesystem::path& scratch) {
  const std::filesystem::path gnuplot = FindProgram("gnuplot");
  if (gnuplot.empty()) {
    throw EnvironmentError(
        "gnuplot, which draws the charts, is not in PATH; install it: "
        "apt-get install --no-install-recommends gnuplot-nox");
  }
  const bool svg = out.extension() == ".svg";
  TETREC_CHECK(svg || out.extension() == ".png", "charts are .svg or .png, not " + out.string());
  std::filesystem::create_directories(scratch);
  std::vector<std::string> curves;
  for (size_t i = 0; i < plot.series.size(); ++i) {
    const std::string data = DataOf(plot, plot.series[i]);
    if (!HasPoints(data)) continue;
    WriteText(scratch / DataName(i), data);
    curves.push_back(Curve(plot.series[i], i));
  }
  if (curves.empty()) throw DataError(fmt::format("chart '{}' has no point to draw", plot.title));
  WriteText(scratch / "chart.gp", Script(plot, curves, svg));

  ChildOptions options;
  options.working_folder = scratch;
  options.time_limit_s = 60;
  const ChildResult result =
      RunChild(gnuplot, {"-d", "chart.gp"}, options);  // without the user's own settings
  if (result.exit_code != 0) {
    throw EnvironmentError(fmt::format("gnuplot ended with exit code {}: {}", result.exit_code,
                                       fmt::join(result.last_lines, " | ")));
  }
  // The script names its own output, so that a hostile path never enters it.
  WriteBytes(out, ReadBytes(scratch / (svg ? "chart.svg" : "chart.png")));
}

}  // namespace tetrec
