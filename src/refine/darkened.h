// Places that are clear in a mesh and opaque in the one that replaces it.
#pragma once

#include "field/field_state.h"
#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A place in a tet of the old mesh, with the weights of the tet's vertices.
struct PlaceInTet {
  glm::vec3 position;
  glm::uvec4 vertices;
  glm::dvec4 weights;
};

struct DarkenedPlaces {
  std::vector<uint32_t> vertices;  // of the old mesh, which the new one is without
  std::vector<PlaceInTet> places;  // centroids of new tets, the most harmful first
};

// Where vertices go or have moved, a new triangulation may join an opaque vertex to a distant clear
// one. The density falls linearly along such an edge, so that it is opaque almost up to its end and
// hides what is behind it, in many pictures. Finds such places among the old vertices `gone` and
// the centroids of new tets: those where the opacity over the mean edge, of the vertex or the tet,
// is larger in the new field than in the old one by 0.3 or more.
// `density`: values at the old vertices [1 / world unit], of any sign. `new_mesh`: of the vertices
// that `of_vertices` makes of the old ones. Both meshes fill the same convex hull.
DarkenedPlaces FindDarkened(const TetMesh& mesh, const std::vector<float>& density,
                            std::span<const uint32_t> gone, const TetMesh& new_mesh,
                            const Prolongation& of_vertices);

}  // namespace tetrec
