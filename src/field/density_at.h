// The density of a field at a point.
#pragma once

#include "field/radiance_field.h"

namespace tetrec {

// The value at a point of the tet [1 / world unit]: linear between the values of its vertices,
// which may be negative, or that of the cell.
double DensityAt(const RadianceField& field, uint32_t tet, const glm::dvec3& point);

}  // namespace tetrec
