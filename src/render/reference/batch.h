// Many rays of the reference renderer, on all cores, summed in the order of the rays.
#pragma once

#include "core/parallel.h"
#include "render/reference/ray.h"
#include "render/reference/render_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace tetrec {

template <class Real>
Real StopDepthOf(double stop_transmittance) {
  return stop_transmittance > 0.0 ? Real(-std::log(stop_transmittance))
                                  : std::numeric_limits<Real>::infinity();
}

// The ray through a point of the image [px].
template <class Real>
WorldRay<Real> RayThrough(const RenderView& view, const glm::dvec2& pixel) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const glm::dvec3 direction = world_from_cam.rotation * view.camera.CamFromImage(pixel);
  return {Vec3<Real>(world_from_cam.translation), Vec3<Real>(glm::normalize(direction))};
}

// The number of rays that a thread processes at a time.
constexpr size_t kRaysPerTask = 64;

// Adds the gradients of `count` rays to `sum`, in the order of the rays for any number of threads.
// ray(i) is a WorldRay, gradient(i) its dL/d(rgb, transmittance).
template <class Real, class RayOf, class GradientOf>
void AddGradients(const RadianceField& field, const TetBoxes& boxes, size_t count, const RayOf& ray,
                  const GradientOf& gradient, Real stop_depth, const IntegralOptions& integral,
                  bool with_positions, ReferenceGradient& sum) {
  // Bounds the memory for gradients that are not yet summed.
  constexpr size_t kTasks = 64;
  std::vector<std::vector<VertexGradient<Real>>> lists(kTasks);
  for (size_t done = 0; done < count; done += kTasks * kRaysPerTask) {
    const size_t rays = std::min(count - done, kTasks * kRaysPerTask);
    ParallelFor(rays, kRaysPerTask, [&](size_t first, size_t last) {
      std::vector<VertexGradient<Real>>& list = lists[first / kRaysPerTask];
      list.clear();
      for (size_t i = done + first; i < done + last; ++i) {
        const Vec4<Real> by_pixel = gradient(i);
        if (by_pixel == Vec4<Real>(Real(0))) continue;
        const WorldRay<Real> at = ray(i);
        AppendRayGradient<Real>(field, CutMesh<Real>(field, boxes, at, stop_depth), at.direction,
                                by_pixel, integral, with_positions, list);
      }
    });
    for (size_t first = 0; first < rays; first += kRaysPerTask) {
      for (const VertexGradient<Real>& part : lists[first / kRaysPerTask]) {
        sum.color_srgb[part.row] += glm::dvec3(part.color_srgb);
        sum.density[part.row] += double(part.density);
        sum.position[part.vertex] += glm::dvec3(part.position);
        sum.absolute_position[part.vertex] += double(part.absolute_position);
      }
    }
  }
}

}  // namespace tetrec
