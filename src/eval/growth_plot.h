// The chart of what a growing mesh gained: judged PSNR over the number of tets.
#pragma once

#include "eval/plot.h"
#include "run/mesh_growth.h"

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// How the mesh of a run grew.
struct GrowthCurve {
  std::string run;  // its name in the legend; not shown if the run is alone
  std::vector<GrowthStep> steps;
};

// For each run the judged PSNR of each mesh, as a line between one standard error of the gain below
// and above, and a vertical line at the size of the result, whose PSNR is not known: the judging
// pictures have been learned by then. Runs of which fewer than two meshes were judged are left out;
// none if that leaves no run.
std::optional<Plot> GrowthPlot(const std::vector<GrowthCurve>& curves);

}  // namespace tetrec
