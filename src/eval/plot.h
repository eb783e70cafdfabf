// Line charts, drawn by gnuplot as a child process.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// One curve; its points are joined in order. Points that are not finite break the line.
struct PlotSeries {
  std::string legend;
  std::vector<double> x, y;
  int color = 0;                // index into a palette of 8, safe for the colour-blind; wraps
  bool on_second_axis = false;  // y axis on the right
  bool marks = true;            // a mark at each point
  bool dashed = false;          // always so on the second axis
  bool crosses = false;         // red crosses without a line, for what failed
};

struct Plot {
  std::string title;
  std::string x_label, y_label, y2_label;
  bool log_x = false, log_y = false, log_y2 = false;  // points <= 0 are left out on such an axis
  int width_px = 900, height_px = 520;
  std::vector<PlotSeries> series;
};

// Draws to `out` (.svg or .png); `scratch` receives gnuplot's script, data and log. Texts may
// contain anything: they are quoted, and control characters become spaces. Throws EnvironmentError
// if gnuplot is missing or fails.
void DrawPlot(const Plot& plot, const std::filesystem::path& out,
              const std::filesystem::path& scratch);

}  // namespace tetrec
