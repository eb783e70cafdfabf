// Scores of tets: the errors of rays, shared out among the tets that they pass.
#pragma once

#include "render/reference/batch_rays.h"
#include "shared/gpu_types.glsl.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

// As march_score.comp, but summed in the order of the rays. `residuals`: of what is shown, for each
// ray; `errors` and `light`: one per tet.
template <class Real>
void AddErrorShares(const RadianceField& field, const TetBoxes& boxes, Real stop_depth,
                    const BatchRays& batch, std::span<const Vec4<Real>> residuals, ScoreKind kind,
                    std::span<double> errors, std::span<double> light) {
  struct Share {
    uint32_t tet;
    Real value, error;
  };
  std::vector<std::vector<Share>> lists((batch.count() + kRaysPerTask - 1) / kRaysPerTask);
  ParallelFor(batch.count(), kRaysPerTask, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!batch.InPicture(i)) continue;
      const Vec3<Real> residual(residuals[i]);
      const Real error = kind == ScoreKind::kSquaredResidual
                             ? glm::dot(residual, residual)
                             : glm::dot(glm::abs(residual), Vec3<Real>(Real(1)));
      Real transmittance(1);
      for (const auto& segment : CutMesh<Real>(field, boxes, RayOf<Real>(batch, i), stop_depth)) {
        const Real opacity = Real(1) - std::exp(-EndsOf(field, segment).depth());
        const Real share = transmittance * opacity;
        if (double(share) > kLeastScoredShare) {
          lists[first / kRaysPerTask].push_back({segment.tet, share, error * share});
        }
        transmittance *= Real(1) - opacity;
      }
    }
  });
  for (const std::vector<Share>& list : lists) {
    for (const Share& share : list) {
      errors[share.tet] += double(share.error);
      if (double(share.value) > kLeastVisibleShare) light[share.tet] += double(share.value);
    }
  }
}

}  // namespace tetrec
