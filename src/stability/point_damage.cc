// Damages to sparse points.
#include "stability/point_damage.h"

#include "geometry/random_vectors.h"

#include <algorithm>

namespace tetrec {

void MisplacePoints(Scene& scene, double share, uint64_t seed) {
  Bounds3 box;
  for (const ScenePoint& point : scene.points) box.Add(point.position);
  MersenneRandom random(seed);
  for (ScenePoint& point : scene.points) {
    const bool moves = random.Uniform() < share;
    const glm::dvec3 place = box.min + box.Size() * RandomInUnitCube(random);
    if (moves) point.position = place;
  }
}

void FlattenPoints(Scene& scene) {
  for (ScenePoint& point : scene.points) point.position.z = scene.subject_bounds.Center().z;
}

void CollapsePoints(Scene& scene) {
  for (ScenePoint& point : scene.points) point.position = scene.subject_bounds.Center();
}

void KeepPoints(Scene& scene, size_t count) {
  scene.points.resize(std::min(count, scene.points.size()));
}

}  // namespace tetrec
