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
    throw UsageError(
        fmt::format("--budget-mb is {}, but the start mesh with {} tets and {} training pixels "
                    "need about {:.0f} "
                    "MB: allow more, or import smaller pictures or start coarser",
                    options.budget_mb, WithThousands(start_tets), WithThousands(pixels),
                    PredictedPeakBytes(double(start_tets), pixels) / 1e6));
  }
  if (options.budget_tets == 0) return kNoBudget;
  if (options.budget_tets >= start_tets) return options.budget_tets;
  throw UsageError(fmt::format(
      "--budget-tets is {}, but the start mesh has {}: allow more, or start coarser (see "
      "tetrec-tetrahedralize)",
      WithThousands(options.budget_tets), WithThousands(start_tets)));
}

}  // namespace tetrec
