// The bound on the size of the mesh that the options give, in tets or as memory.
#include "optimize/mesh_budget.h"

#include "core/error.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr double kFixedBytes = 150e6, kBytesPerPixel = 10;

double BytesPerTet(HarmonicsChoice harmonics) {
  const bool may_reach_degree_3 =
      harmonics == HarmonicsChoice::kDegree3 || harmonics == HarmonicsChoice::kAuto;
  return may_reach_degree_3 ? 380 : 330;
}

uint64_t TetsWithin(const OptimizeOptions& options, uint64_t pixels) {
  const double room =
      double(options.budget_mb) * 1e6 - PredictedPeakBytes(options.harmonics, 0, pixels);
  return uint64_t(std::max(0.0, room) / BytesPerTet(options.harmonics));
}

}  // namespace

double PredictedPeakBytes(HarmonicsChoice harmonics, double tets, uint64_t pixels) {
  return kFixedBytes + kBytesPerPixel * double(pixels) + BytesPerTet(harmonics) * tets;
}

uint64_t TetBudget(const OptimizeOptions& options, uint64_t pixels, uint64_t start_tets) {
  if (options.budget_mb > 0) {
    const uint64_t tets = TetsWithin(options, pixels);
    if (tets >= start_tets) return tets;
    throw UsageError(fmt::format(
        "the start mesh with {} tets and {} training pixels needs about {:.0f} MB, and "
        "--budget-mb allows {}: allow more, or import smaller pictures or start coarser",
        WithThousands(start_tets), WithThousands(pixels),
        PredictedPeakBytes(options.harmonics, double(start_tets), pixels) / 1e6,
        options.budget_mb));
  }
  if (options.budget_tets == 0) return kNoBudget;
  if (options.budget_tets >= start_tets) return options.budget_tets;
  throw UsageError(fmt::format(
      "the start mesh has {} tets, and --budget-tets allows {}: allow more, or start coarser (see "
      "tetrec-tetrahedralize)",
      WithThousands(start_tets), WithThousands(options.budget_tets)));
}

}  // namespace tetrec
