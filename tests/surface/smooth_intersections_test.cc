// Smoothed surfaces of photos' roughness, judged by CGAL.
#include "core/random.h"
#include "surface/shapes.h"
#include "surface/smooth.h"
#include "surface/vertex_normals.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;

size_t SelfIntersections(const TriangleMesh& surface) {
  CgalMesh mesh;
  std::vector<CgalMesh::Vertex_index> ids;
  for (const glm::vec3& p : surface.positions) ids.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const glm::uvec3& t : surface.triangles) mesh.add_face(ids[t.x], ids[t.y], ids[t.z]);
  std::vector<std::pair<CgalMesh::Face_index, CgalMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(pairs));
  return pairs.size();
}

TEST(SmoothByNormals, MakesNoSelfIntersections) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const auto& shape : {Ball, Torus}) {
      const TetMesh mesh = JitteredBox(16);
      std::vector<float> level = Sampled(mesh, shape);
      MersenneRandom random(seed);
      for (float& l : level) l += float(0.02 * (2 * random.Uniform() - 1));
      const TriangleMesh rough = AsTriangles(MarchTetrahedra(mesh, level, 0));
      ASSERT_EQ(SelfIntersections(rough), 0u);
      const TriangleMesh smooth = SmoothByNormals(rough, {.max_move = 0.01});
      EXPECT_NE(smooth.positions, rough.positions);
      EXPECT_EQ(SelfIntersections(smooth), 0u) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace tetrec
