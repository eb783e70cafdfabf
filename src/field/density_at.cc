// The density of a field at a point.
#include "field/density_at.h"

#include "mesh/locate.h"

namespace tetrec {

double DensityAt(const RadianceField& field, uint32_t tet, const glm::dvec3& point) {
  if (field.storage == FieldStorage::kCell) return field.density[tet];
  const glm::uvec4& ids = field.mesh.tets[tet];
  const glm::dvec4 weights = WeightsInTet(field.mesh, tet, point);
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += weights[i] * double(field.density[ids[i]]);
  return sum;
}

}  // namespace tetrec
