// The renderer that judges the others, on the CPU, without neighbour links or rounding tricks.
// Every ray is cut with every tet whose box it meets, so the mesh need not be convex or connected,
// only free of overlap. For a ray in the plane of a face, up to rounding, both sides or neither may
// claim a stretch. The bits are the same for any number of threads.
#pragma once

#include "render/renderer.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

struct ReferenceImage {
  int width = 0, height = 0;
  std::vector<glm::dvec3> color_srgb;  // (height x width) before the background
  std::vector<double> optical_depth;   // (height x width)
  std::vector<double> length;          // (height x width) of the ray inside the mesh [world units]
};

// As FieldGradient, in double, always with positions.
struct ReferenceGradient {
  std::vector<glm::dvec3> color_srgb;
  std::vector<double> density;
  std::vector<glm::dvec3> position;
  std::vector<double> absolute_position;

  explicit ReferenceGradient(const RadianceField& field)
      : ReferenceGradient(RowCount(field), field.mesh.positions.size()) {}
  ReferenceGradient(size_t rows, size_t vertices)
      : color_srgb(rows, glm::dvec3(0.0)),
        density(rows, 0.0),
        position(vertices, glm::dvec3(0.0)),
        absolute_position(vertices, 0.0) {}
};

// One ray through every pixel's centre. A ray ends after the tet in which its transmittance falls
// to `stop_transmittance`; 0 means never.
ReferenceImage RenderReference(const RadianceField& field, const RenderView& view,
                               double stop_transmittance, const IntegralOptions& integral = {});

// The gradient of a loss whose gradient by (rgb, transmittance) of each pixel is `pixel_gradient`,
// (height x width).
ReferenceGradient BackpropagateReference(const RadianceField& field, const RenderView& view,
                                         std::span<const glm::dvec4> pixel_gradient,
                                         double stop_transmittance,
                                         const IntegralOptions& integral = {});

}  // namespace tetrec
