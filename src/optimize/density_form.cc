// The choice between density of positive values and of either sign.
#include "optimize/density_form.h"

#include "core/quantile.h"
#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

namespace tetrec {
namespace {

// Between what is best for opaque subjects (half an optical depth) and for volumes of soft density
// (a twentieth).
constexpr double kOpticalDepthOfScale = 0.2;

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

Attribute LearnedDensity(DensityForm form, bool has_alpha, const RadianceField& start) {
  const bool is_linear = start.storage == FieldStorage::kVertex;
  const bool is_signed =
      form == DensityForm::kSigned || (form == DensityForm::kAuto && has_alpha && is_linear);
  if (!is_signed || start.mesh.tets.empty()) return kDensityAttribute;
  return SignedDensity(float(kOpticalDepthOfScale / MedianEdge(start.mesh)));
}

}  // namespace tetrec
