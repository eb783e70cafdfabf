// A field's attributes moved from vertices to tets, and back.
#include "field/change_storage.h"

#include "core/error.h"

#include <cmath>

namespace tetrec {
namespace {

// Means of what lies around a place.
struct Means {
  double weight = 0, density = 0;
  glm::dvec3 color{0}, dense_color{0};

  void Add(double w, double d, const glm::dvec3& c) {
    weight += w;
    density += w * d;
    color += w * c;
    dense_color += w * d * c;
  }
  float Density() const { return weight > 0 ? float(density / weight) : 0.0f; }
  glm::vec3 Color() const {
    if (density > 0) return glm::vec3(dense_color / density);
    return weight > 0 ? glm::vec3(color / weight) : glm::vec3(0.0f);
  }
};

double Volume(const TetMesh& mesh, const glm::uvec4& tet) {
  const glm::dvec3 a(mesh.positions[tet[0]]);
  const glm::dvec3 b = glm::dvec3(mesh.positions[tet[1]]) - a,
                   c = glm::dvec3(mesh.positions[tet[2]]) - a,
                   d = glm::dvec3(mesh.positions[tet[3]]) - a;
  return std::abs(glm::dot(b, glm::cross(c, d))) / 6.0;
}

}  // namespace

RadianceField WithStorage(const RadianceField& field, FieldStorage storage) {
  if (field.storage == storage) return field;
  RadianceField result;
  result.mesh = field.mesh;
  result.storage = storage;
  std::vector<Means> means(RowCount(result));
  for (size_t t = 0; t < field.mesh.tets.size(); ++t) {
    const glm::uvec4& tet = field.mesh.tets[t];
    const double volume = Volume(field.mesh, tet);
    for (int i = 0; i < 4; ++i) {
      if (storage == FieldStorage::kCell) {
        means[t].Add(1.0, field.density[tet[i]], glm::dvec3(field.color_srgb[tet[i]]));
      } else {
        means[tet[i]].Add(volume, field.density[t], glm::dvec3(field.color_srgb[t]));
      }
    }
  }
  for (const Means& mean : means) {
    result.density.push_back(mean.Density());
    result.color_srgb.push_back(mean.Color());
  }
  return result;
}

}  // namespace tetrec
