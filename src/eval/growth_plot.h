// The chart of what a growing mesh gained: judged PSNR over the number of tets.
#pragma once

#include "eval/plot.h"
#include "run/mesh_growth.h"

#include <optional>
#include <vector>

namespace tetrec {

// The judged PSNR of each mesh, as a line between one standard error of the gain below and above,
// and a vertical line at the size of the result, whose PSNR is not known: the judging pictures have
// been learned by then. None if fewer than two meshes were judged.
std::optional<Plot> GrowthPlot(const std::vector<GrowthStep>& steps);

}  // namespace tetrec
