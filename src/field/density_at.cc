// The density of a field at a point.
#include "field/density_at.h"

#include <algorithm>

namespace tetrec {

double DensityAt(const RadianceField& field, uint32_t tet, const glm::dvec3& point) {
  if (field.storage == FieldStorage::kCell) return field.density[tet];
  const glm::uvec4& ids = field.mesh.tets[tet];
  double sum = 0, weights = 0;
  for (int i = 0; i < 4; ++i) {
    // Barycentric: six times the volume of the tet with this vertex replaced by the point.
    glm::dvec3 p[4];
    for (int k = 0; k < 4; ++k) p[k] = k == i ? point : glm::dvec3(field.mesh.positions[ids[k]]);
    const double weight =
        std::max(0.0, glm::dot(p[3] - p[0], glm::cross(p[1] - p[0], p[2] - p[0])));
    sum += weight * field.density[ids[i]];
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

}  // namespace tetrec
