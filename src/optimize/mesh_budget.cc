// The bound on the size of the mesh that the options give, in tets or as memory.
#include "optimize/mesh_budget.h"

#include "core/error.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr double kFixedBytes = 120e6, kBytesPerPixel = 14, kBytesPerTet = 330;

uint64_t TetsWithin(double megabytes, uint64_t pixels) {
  const double room = megabytes * 1e6 - PredictedPeakBytes(0, pixels);
  return uint64_t(std::max(0.0, room) / kBytesPerTet);
}

}  // namespace

double PredictedPeakBytes(double tets, uint64_t pixels) {
  return kFixedBytes + kBytesPerPixel * double(pixels) + kBytesPerTet * tets;
}

uint64_t TetBudget(const OptimizeOptions& options, uint64_t pixels, uint64_t start_tets) {
  if (options.budget_mb > 0) {
    const uint64_t tets = TetsWithin(double(options.budget_mb), pixels);
    if (tets >= start_tets) return tets;
    throw UsageError(fmt::format(
        "the start mesh with {} tets and {} training pixels needs about {:.0f} MB, and "
        "--budget-mb allows {}: allow more, or import smaller pictures or start coarser",
        WithThousands(start_tets), WithThousands(pixels),
        PredictedPeakBytes(double(start_tets), pixels) / 1e6, options.budget_mb));
  }
  if (options.budget_tets == 0) return kNoBudget;
  if (options.budget_tets >= start_tets) return options.budget_tets;
  throw UsageError(fmt::format(
      "the start mesh has {} tets, and --budget-tets allows {}: allow more, or start coarser (see "
      "tetrec-tetrahedralize)",
      WithThousands(start_tets), WithThousands(options.budget_tets)));
}

}  // namespace tetrec
