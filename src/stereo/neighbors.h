// Which views are matched with which, and between which depths.
#pragma once

#include "geometry/bounds3.h"
#include "stereo/stereo_view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Points at which the views' overlap is judged: the sparse points, or, if a scene has fewer than 50
// of them, a grid in the subject's box.
std::vector<glm::dvec3> OverlapPoints(const Scene& scene);

// For each view the others that see the same points at a useful angle, the best first, at most
// `count`. A pair's score is the sum over the points that both see of exp(-(a - 10 deg)^2 / (2
// s^2)) with s = 5 deg below and 10 deg above, times the smaller over the larger of the two
// distances (like MVSNet's choice of source views, Yao et al. 2018). Of views from one place,
// within a hundredth of the median distance to what they show, only the best is taken, and none
// from the view's own place.
std::vector<std::vector<uint32_t>> ChooseNeighbors(std::span<const StereoView> views,
                                                   std::span<const glm::dvec3> points,
                                                   size_t count);

// Depths between which a view's surfaces are searched [world units, z in the camera frame].
struct DepthRange {
  double nearest = 0, farthest = 0;
  bool IsEmpty() const { return !(nearest > 0 && farthest > nearest); }
};

// From three quarters of the depth of the nearest points that the view sees to eight times that of
// the farthest (1 and 98 % quantiles); empty if it sees fewer than 5.
// A subject with alpha is never outside its box, which then bounds the range.
DepthRange FindDepthRange(const StereoView& view, std::span<const glm::dvec3> points,
                          const Scene& scene);

}  // namespace tetrec
