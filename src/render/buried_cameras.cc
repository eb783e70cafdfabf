// Cameras that stand inside of opaque density.
#include "render/buried_cameras.h"

#include "core/quantile.h"
#include "field/density_at.h"
#include "mesh/locate.h"

#include <cmath>

namespace tetrec {
namespace {

constexpr double kNearShare = 0.1;  // of the distance to what the view shows
constexpr double kNearestPoints = 0.05;
constexpr size_t kFewestPoints = 10;

// 0 inside of the box.
double DistanceToBox(const Bounds3& box, const glm::dvec3& point) {
  return glm::distance(point, glm::clamp(point, box.min, box.max));
}

// [world units]; 0 if it is unknown.
double DistanceToScene(const Scene& scene, const View& view, const glm::dvec3& center) {
  const Camera& camera = scene.cameras[size_t(view.camera)];
  std::vector<double> depths;
  for (const ScenePoint& point : scene.points) {
    const glm::dvec3 in_cam = view.cam_from_world * point.position;
    if (camera.Shows(in_cam)) depths.push_back(in_cam.z);
  }
  if (depths.size() < kFewestPoints) return DistanceToBox(scene.subject_bounds, center);
  return Quantile(std::move(depths), kNearestPoints);
}

}  // namespace

std::vector<std::string> BuriedCameras(const RadianceField& field, const Scene& scene) {
  std::vector<std::string> names;
  uint32_t last = 0;
  for (const View& view : scene.views) {
    const glm::dvec3 center = view.cam_from_world.Inverse().translation;
    const uint32_t tet = FindTet(field.mesh, center, last);
    if (tet == kNoTet) continue;
    last = tet;
    const double near = kNearShare * DistanceToScene(scene, view, center);
    if (DensityAt(field, tet, center) * near > std::log(2.0)) names.push_back(view.name);
  }
  return names;
}

}  // namespace tetrec
