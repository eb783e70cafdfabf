// The first mesh and field from a dense cloud of points.
#pragma once

#include "field/radiance_field.h"
#include "scene/scene.h"
#include "start/initial_field.h"
#include "start/start_points.h"
#include "stereo/fusion.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

struct DenseStartOptions {
  double layer_spacing = 0.7;  // distance of the layers from the points, in the points' spacing
  double surface_depth = 1.0;  // optical depth of points and the layer behind, over their mean edge
  double free_depth = 0.002;   // of vertices in free space, over their mean edge
};

struct DenseStart {
  RadianceField field;
  uint64_t surface = 0, front = 0, behind = 0;  // vertices of the points and of the two layers
  uint64_t fill = 0;
  uint64_t dropped_far = 0;  // beyond the far shell
  uint64_t sight_lines = 0, lost_lines = 0;
  uint64_t full_tets = 0, free_tets = 0;
  uint64_t free_points = 0;  // points that the cut leaves in free space: mistaken
  double far_radius = 0;     // [world units]
};

// `centers[v]`: the camera centre of the view that DensePoint::views calls v. `sparse`: further
// surface points, for places that the dense ones leave empty.
DenseStart StartFromDense(std::span<const DensePoint> points, std::span<const ScenePoint> sparse,
                          std::span<const glm::dvec3> centers,
                          std::span<const glm::dvec3> all_cameras, const Bounds3& subject,
                          const PointStartOptions& shell, const DenseStartOptions& options,
                          const InitialFieldOptions& field, uint64_t seed);

}  // namespace tetrec
