// The boxes find every tet that a ray meets.
#include "render/reference/tet_boxes.h"

#include "geometry/bounds3.h"
#include "render/reference/ray.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace tetrec::test {
namespace {

// Hard rays: along axes, through vertices, from a vertex, from far away.
std::vector<WorldRay<double>> HardRays(const TetMesh& mesh, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<size_t> any(0, mesh.positions.size() - 1);
  const auto vertex = [&] { return glm::dvec3(mesh.positions[any(random)]); };
  std::vector<WorldRay<double>> rays;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 direction =
        glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    glm::dvec3 axis(0.0);
    axis[i % 3] = i % 2 ? 1.0 : -1.0;
    const glm::dvec3 a = vertex(), b = vertex();
    rays.push_back({a - 1e5 * direction, direction});
    rays.push_back({a - 3.0 * axis, axis});
    rays.push_back({a, axis});
    if (a != b) rays.push_back({a, glm::normalize(b - a)});
    rays.push_back({a + 0.1 * direction, direction});
  }
  return rays;
}

bool IsInBox(const TetMesh& mesh, uint32_t tet, const glm::dvec3& point) {
  Bounds3 box;
  for (int i = 0; i < 4; ++i) box.Add(glm::dvec3(mesh.positions[mesh.tets[tet][i]]));
  return box.Contains(point);
}

TEST(TetBoxes, NoTetThatARayMeetsIsMissed) {
  for (int points : {0, 1, 20, 500}) {
    const TetMesh mesh = RandomBoxMesh(points, uint32_t(points));
    const TetBoxes boxes = MakeTetBoxes(mesh);
    size_t met = 0, near = 0;
    for (const WorldRay<double>& ray : HardRays(mesh, 40, 5)) {
      std::set<uint32_t> candidates;
      ForEachTetNear(boxes, BoxRay(ray.origin, ray.direction), [&](uint32_t tet) {
        EXPECT_TRUE(candidates.insert(tet).second) << "tet " << tet << " came twice";
      });
      near += candidates.size();
      for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
        const RaySegment<double> segment = CutTet(mesh, t, ray);
        const double middle = 0.5 * (segment.begin + segment.end);
        // If a ray is in the plane of a face, up to rounding, the cut may be anywhere.
        if (segment.begin >= segment.end || !IsInBox(mesh, t, ray.origin + middle * ray.direction))
          continue;
        ++met;
        EXPECT_TRUE(candidates.contains(t)) << points << " points, tet " << t;
      }
    }
    EXPECT_GT(met, 0u);
    // The boxes pay off: they find far fewer tets than there are.
    if (points == 500) {
      EXPECT_LT(near, 200 * mesh.tets.size() / 10);
    }
  }
}

TEST(TetBoxes, OfNoTetThereAreNone) {
  const TetBoxes boxes = MakeTetBoxes({});
  ForEachTetNear(boxes, BoxRay({0, 0, 0}, {0, 0, 1}), [](uint32_t) { FAIL(); });
}

}  // namespace
}  // namespace tetrec::test
