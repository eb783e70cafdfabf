// What rays say of a vertex in the middle of each edge (EdgeSums).
#pragma once

#include "mesh/mesh_edges.h"
#include "render/reference/seen_fields.h"
#include "shared/edge_hat.glsl.h"
#include "shared/gpu_types.glsl.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

// As march_edges.comp, but summed in the order of the rays, with densities in world units.
// `residuals`: of what is shown; `colors`: colour before the background and transmittance, both of
// each ray.
template <class Real>
void AddEdgeShares(const RadianceField& field, const TetBoxes& boxes, Real stop_depth,
                   const BatchRays& batch, const glm::vec3& background,
                   std::span<const Vec4<Real>> residuals, std::span<const Vec4<Real>> colors,
                   const MeshEdges& edges, std::span<EdgeSums> sums) {
  struct Share {
    uint32_t edge;
    Vec4<Real> slopes;
    Real color_curvature, density_curvature;
  };
  const SeenFields seen = FieldsSeenBy(batch, field);
  std::vector<std::vector<Share>> lists((batch.count() + kRaysPerTask - 1) / kRaysPerTask);
  ParallelFor(batch.count(), kRaysPerTask, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!batch.InPicture(i)) continue;
      const RadianceField& of_view = FieldFor(seen, batch, i);
      const Vec3<Real> residual(residuals[i]);
      Vec3<Real> behind = Vec3<Real>(colors[i]) + colors[i].a * Vec3<Real>(background);
      Real before(1);
      for (const auto& segment : CutMesh<Real>(field, boxes, RayOf<Real>(batch, i), stop_depth)) {
        const SegmentEnds<Real> ends = EndsOf(of_view, segment);
        const Vec3<Real> color = Real(0.5) * (ends.c0 + ends.c1);
        const Real after = before * std::exp(-ends.depth());
        const Real opacity = before - after;
        before = after;
        behind -= opacity * color;
        if (!(double(opacity) > kLeastScoredShare)) continue;
        const Vec3<Real> by_density = ends.length * (after * color - behind);
        const auto w0 = glm::mix(segment.begin_weights, segment.end_weights, ends.cut.begin);
        const auto w1 = glm::mix(segment.begin_weights, segment.end_weights, ends.cut.end);
        for (int e = 0; e < 6; ++e) {
          const auto [a, b] = kTetEdges[e];
          const Real hat = MeanHat(w0[a], w0[b], w1[a], w1[b]);
          lists[first / kRaysPerTask].push_back(
              {edges.of_tets[6 * segment.tet + size_t(e)],
               hat * Vec4<Real>(opacity * residual, glm::dot(residual, by_density)),
               hat * hat * opacity * opacity, hat * hat * glm::dot(by_density, by_density)});
        }
      }
    }
  });
  for (const std::vector<Share>& list : lists) {
    for (const Share& share : list) {
      EdgeSums& sum = sums[share.edge];
      sum.color += glm::dvec3(share.slopes);
      sum.density += double(share.slopes.a);
      sum.color_curvature += double(share.color_curvature);
      sum.density_curvature += double(share.density_curvature);
    }
  }
}

}  // namespace tetrec
