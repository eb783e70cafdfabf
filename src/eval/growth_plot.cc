// The chart of what a growing mesh gained.
#include "eval/growth_plot.h"

#include <algorithm>

namespace tetrec {

std::optional<Plot> GrowthPlot(const std::vector<GrowthStep>& steps) {
  PlotSeries judged{"judging pictures", {}, {}, 1, false, true};
  PlotSeries below{"- 1 standard error of the gain", {}, {}, 5, false, false, true};
  PlotSeries above{"+ 1 standard error of the gain", {}, {}, 5, false, false, true};
  for (const GrowthStep& step : steps) {
    if (!(step.psnr > 0)) continue;
    for (PlotSeries* series : {&judged, &below, &above}) series->x.push_back(double(step.tets));
    judged.y.push_back(step.psnr);
    below.y.push_back(step.psnr - step.gain_standard_error);
    above.y.push_back(step.psnr + step.gain_standard_error);
  }
  if (judged.x.size() < 2) return {};
  const double tets = double(steps.back().tets);
  const double lowest = *std::min_element(below.y.begin(), below.y.end());
  const double highest = *std::max_element(above.y.begin(), above.y.end());
  Plot plot;
  plot.title = "Size against gain";
  plot.x_label = "tets";
  plot.y_label = "judged PSNR [dB]";
  plot.height_px = 400;
  plot.series = {judged,
                 below,
                 above,
                 {"size of the result", {tets, tets}, {lowest, highest}, 2, false, false}};
  return plot;
}

}  // namespace tetrec
