// The bound on the size of the mesh that the options give, in tets or as memory.
#include "optimize/mesh_budget.h"

#include "core/error.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr double kFixedBytes = 145e6, kBytesPerPixel = 14;

double BytesPerTet(uint32_t harmonics_degree) { return harmonics_degree < 3 ? 330 : 380; }

}  // namespace

double PredictedPeakBytes(uint32_t harmonics_degree, double tets, uint64_t pixels) {
  return kFixedBytes + kBytesPerPixel * double(pixels) + BytesPerTet(harmonics_degree) * tets;
}

uint64_t TetBudget(const OptimizeOptions& options, const TrainingSet& set, uint64_t start_tets) {
  if (options.budget_mb > 0) {
    const uint32_t degree = HighestDegree(options.harmonics, set.views.size());
    const double room = double(options.budget_mb) * 1e6 - PredictedPeakBytes(degree, 0, set.pixels);
    const auto tets = uint64_t(std::max(0.0, room) / BytesPerTet(degree));
    if (tets >= start_tets) return tets;
    throw UsageError(fmt::format(
        "the start mesh with {} tets and {} training pixels needs about {:.0f} MB, and "
        "--budget-mb allows {}: allow more, or import smaller pictures or start coarser",
        WithThousands(start_tets), WithThousands(set.pixels),
        PredictedPeakBytes(degree, double(start_tets), set.pixels) / 1e6, options.budget_mb));
  }
  if (options.budget_tets == 0) return kNoBudget;
  if (options.budget_tets >= start_tets) return options.budget_tets;
  throw UsageError(fmt::format(
      "the start mesh has {} tets, and --budget-tets allows {}: allow more, or start coarser (see "
      "tetrec-tetrahedralize)",
      WithThousands(start_tets), WithThousands(options.budget_tets)));
}

}  // namespace tetrec
