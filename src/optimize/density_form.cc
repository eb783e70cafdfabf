// The choice of what density is learned by, and whether its values may be negative.
#include "optimize/density_form.h"

#include "core/quantile.h"

#include <glm/glm.hpp>

#include <limits>

namespace tetrec {
namespace {

constexpr double kSoftplusScale = 15;  // in units of DensityOfSurfaces

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
  if (form == DensityForm::kAuto) {
    const bool is_linear = start.storage == FieldStorage::kVertex;
    form = has_alpha && is_linear ? DensityForm::kSigned : DensityForm::kPositive;
  }
  if (form == DensityForm::kPositive || start.mesh.tets.empty()) return kDensityAttribute;
  const double surface = DensityOfSurfaces(start.mesh);
  return form == DensityForm::kSigned ? SignedDensity(float(surface))
                                      : SoftplusDensity(float(kSoftplusScale * surface));
}

}  // namespace tetrec
