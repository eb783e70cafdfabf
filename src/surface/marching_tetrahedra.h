// Level sets of piecewise linear functions on tet meshes.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "mesh/tet_mesh.h"
#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A vertex of the level set on an edge of the mesh, at (1 - t) * inside + t * outside.
struct EdgeCut {
  uint32_t inside, outside;  // vertex ids: level > isovalue, level <= isovalue
  float t;
};

struct LevelSet {
  std::vector<EdgeCut> cuts;          // (N) one per cut edge, shared by all tets around it
  std::vector<glm::vec3> positions;   // (N) [world units]
  std::vector<glm::uvec3> triangles;  // (M) counter-clockwise seen from outside
  std::vector<uint32_t> tets;         // (M) the tet that made the triangle
};

// A cut keeps this share of its edge as a distance from both ends, so that no triangle vanishes.
inline constexpr double kLeastCutShare = 1e-3;

// {x : level(x) = isovalue}, where level is linear inside each tet and larger inside the surface.
//   level   (V) one finite value per vertex
// Closed unless boundary faces are cut, and always a 2-manifold: a vertex whose level is exactly
// the isovalue counts as outside. Throws DataError if a level or the isovalue is not finite or
// level.size() != V. Method: Doi and Koide, An efficient method of triangulating equi-valued
// surfaces by using tetrahedral cells, 1991.
LevelSet MarchTetrahedra(const TetMesh& mesh, std::span<const float> level, float isovalue);

// The triangles whose mark is not 0, and the vertices they use.
//   marks   (M)
LevelSet KeepTriangles(const LevelSet& set, std::span<const uint8_t> marks);

// Keeps the triangles whose three vertices are inside the bounds, and the vertices they use.
LevelSet CropTo(const LevelSet& set, const Bounds3& bounds);

// The level set with the field's colours. On a cut edge the colours of both ends are also weighted
// by density, because the outer end, where nothing was seen, has no meaningful colour.
TriangleMesh ColoredSurface(const LevelSet& set, const RadianceField& field);

}  // namespace tetrec
