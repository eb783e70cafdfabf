// The field that optimisation starts from.
#pragma once

#include "field/radiance_field.h"
#include "start/start_points.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace tetrec {

// The start is thin, so that light reaches every vertex and each of them gets a gradient. Dense fog
// in front of the subject would have to be removed first, and might stay.
struct InitialFieldOptions {
  double density = 2.0;              // of kSurface and kInner in a carved subject [1 / world unit]
  double point_optical_depth = 0.1;  // of a sparse point, over its mean edge
  double fill_optical_depth = 0.02;  // of other vertices of a photo scene, over their mean edge
  double far_optical_depth = 1.0;    // of the far shell and the corners, over their mean edge
};

// For masked subjects: `density` inside and on the surface, a twentieth of it beside the surface, a
// hundredth outside.
RadianceField MakeSubjectField(TetMesh mesh, std::span<const VertexKind> kinds,
                               const InitialFieldOptions& options);

// For photos: density by optical depth over the mean edge of each vertex. `colors_srgb` contains
// the colours of the sparse points; other vertices get the mean of their neighbours, ring by ring
// from the points outward.
RadianceField MakePhotoField(TetMesh mesh, std::span<const VertexKind> kinds,
                             std::span<const std::optional<glm::vec3>> colors_srgb,
                             const InitialFieldOptions& options);

// The same with an optical depth over its mean edge for each vertex.
RadianceField MakeFieldByDepth(TetMesh mesh, std::span<const double> optical_depths,
                               std::span<const std::optional<glm::vec3>> colors_srgb);

}  // namespace tetrec
