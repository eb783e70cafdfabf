// The choice between density of positive values and of either sign.
#include "optimize/density_form.h"

#include "core/quantile.h"

#include <glm/glm.hpp>

#include <limits>

namespace tetrec {
namespace {

double MedianEdge(const TetMesh& mesh) {
  std::vector<double> lengths;
  for (const glm::uvec4& tet : mesh.tets) {
    for (const auto& ends : kTetEdges) {
      lengths.push_back(glm::distance(glm::dvec3(mesh.positions[tet[ends[0]]]),
                                      glm::dvec3(mesh.positions[tet[ends[1]]])));
    }
  }
  return Quantile(std::move(lengths), 0.5);
}

}  // namespace

double DensityOfSurfaces(const TetMesh& mesh) {
  return mesh.tets.empty() ? std::numeric_limits<double>::infinity() : 0.2 / MedianEdge(mesh);
}

Attribute LearnedDensity(DensityForm form, bool has_alpha, const RadianceField& start) {
  const bool is_linear = start.storage == FieldStorage::kVertex;
  const bool is_signed =
      form == DensityForm::kSigned || (form == DensityForm::kAuto && has_alpha && is_linear);
  if (!is_signed || start.mesh.tets.empty()) return kDensityAttribute;
  return SignedDensity(float(DensityOfSurfaces(start.mesh)));
}

}  // namespace tetrec
