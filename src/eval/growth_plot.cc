// The chart of what a growing mesh gained.
#include "eval/growth_plot.h"

#include <algorithm>

namespace tetrec {
namespace {

// The lines of one run, in the order in which they are drawn.
struct GrowthLines {
  PlotSeries judged, below, above, result;
};

bool WasTakenBack(GrowthDecision decision) {
  return decision == GrowthDecision::kTooCoarse || decision == GrowthDecision::kTooFine;
}

GrowthLines LinesOf(const std::vector<GrowthStep>& steps) {
  GrowthLines lines;
  for (const GrowthStep& step : steps) {
    if (!(step.psnr > 0) || WasTakenBack(step.decision)) continue;
    for (PlotSeries* series : {&lines.judged, &lines.below, &lines.above}) {
      series->x.push_back(double(step.tets));
    }
    lines.judged.y.push_back(step.psnr);
    lines.below.y.push_back(step.psnr - step.gain_standard_error);
    lines.above.y.push_back(step.psnr + step.gain_standard_error);
  }
  if (lines.judged.x.empty()) return lines;
  const double tets = double(steps.back().tets);
  lines.result.x = {tets, tets};
  lines.result.y = {std::ranges::min(lines.below.y), std::ranges::max(lines.above.y)};
  for (PlotSeries* line : {&lines.below, &lines.above, &lines.result}) line->marks = false;
  for (PlotSeries* line : {&lines.below, &lines.above}) line->dashed = true;
  return lines;
}

void NameParts(GrowthLines& lines) {
  lines.judged.legend = "judging pictures";
  lines.below.legend = "- 1 standard error of the gain";
  lines.above.legend = "+ 1 standard error of the gain";
  lines.result.legend = "size of the result";
  lines.judged.color = 1;
  lines.below.color = lines.above.color = 5;
  lines.result.color = 2;
}

void NameRun(const std::string& run, int color, GrowthLines& lines) {
  lines.judged.legend = run;
  for (PlotSeries* line : {&lines.judged, &lines.below, &lines.above, &lines.result}) {
    line->color = color;
  }
}

}  // namespace

std::optional<Plot> GrowthPlot(const std::vector<GrowthCurve>& curves) {
  Plot plot;
  plot.title = "Size against gain";
  plot.x_label = "tets";
  plot.y_label = "judged PSNR [dB]";
  plot.height_px = 400;
  for (size_t i = 0; i < curves.size(); ++i) {
    GrowthLines lines = LinesOf(curves[i].steps);
    if (lines.judged.x.size() < 2) continue;
    if (curves.size() == 1) {
      NameParts(lines);
    } else {
      NameRun(curves[i].run, int(i), lines);
    }
    for (PlotSeries* line : {&lines.judged, &lines.below, &lines.above, &lines.result}) {
      plot.series.push_back(std::move(*line));
    }
  }
  if (plot.series.empty()) return {};
  if (curves.size() > 1) {
    plot.title += " (dashed: 1 standard error of the gain; upright: size of the result)";
  }
  return plot;
}

}  // namespace tetrec
