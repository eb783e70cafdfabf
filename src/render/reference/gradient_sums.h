// The sums of gradients since the last update, on the CPU.
#pragma once

#include "field/layout.h"
#include "render/reference/render_picture.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

class ReferenceSums {
 public:
  ReferenceSums() = default;
  // Zeros.
  explicit ReferenceSums(const RadianceField& field);

  // The sum of dL/dvalue of a component of a row.
  double& At(size_t row, size_t component);

  // Adds gradients by the colours that a camera at `center` sees, and all others. `field`: that of
  // the sums.
  void Add(const ReferenceGradient& gradient, const RadianceField& field, const glm::dvec3& center,
           bool with_positions);
  void Add(const GradientSums& given);

  // Read the sums and set them to zero, as TrainingRenderer describes.
  GradientSums Take();
  GradientSums TakePositions();
  // Sets all sums but those by positions to zero.
  void ClearValues();

 private:
  ReferenceGradient standard_{0, 0};  // by colour, density and position
  std::vector<double> others_;        // by attributes beside these, row by row
  size_t components_ = kStandardComponents;
  int harmonics_degree_ = 0;
  bool has_positions_ = false;
};

}  // namespace tetrec
