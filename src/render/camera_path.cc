// Orbits, and splines through cameras.
#include "render/camera_path.h"

#include "core/error.h"
#include "core/quantile.h"
#include "geometry/look_at.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetrec {
namespace {

glm::dvec3 CenterOf(const View& view) { return view.cam_from_world.Inverse().translation; }

// A camera on the path, and how far along the polygon of centres it is.
struct Key {
  glm::dvec3 center;
  glm::dquat world_from_cam;
  double at = 0;
};

std::vector<Key> KeysOf(const Scene& scene, const std::vector<int>& views) {
  std::vector<Key> keys;
  double length = 0;
  for (const int view : views) {
    const Rigid3 pose = scene.views[size_t(view)].cam_from_world.Inverse();
    keys.push_back({pose.translation, glm::quat_cast(pose.rotation)});
    if (keys.size() > 1) length += glm::distance(keys.back().center, keys.end()[-2].center);
  }
  // Cameras that only turn need time too: none is closer to the next than a tenth of the mean.
  const double step = length > 0 ? 0.1 * length / double(keys.size() - 1) : 1;
  for (size_t i = 1; i < keys.size(); ++i) {
    keys[i].at = keys[i - 1].at + std::max(step, glm::distance(keys[i].center, keys[i - 1].center));
  }
  return keys;
}

glm::dvec3 Slope(const Key& a, const Key& b) { return (b.center - a.center) / (b.at - a.at); }

// Of the parabola through a key and its neighbours; at an end, of the line to the only one.
glm::dvec3 Tangent(const std::vector<Key>& keys, size_t i) {
  if (i == 0) return Slope(keys[0], keys[1]);
  if (i + 1 == keys.size()) return Slope(keys[i - 1], keys[i]);
  const double before = keys[i].at - keys[i - 1].at, after = keys[i + 1].at - keys[i].at;
  return (after * Slope(keys[i - 1], keys[i]) + before * Slope(keys[i], keys[i + 1])) /
         (before + after);
}

// Between key i and the next, at `share` of the way.
Rigid3 Between(const std::vector<Key>& keys, size_t i, double share) {
  const Key &a = keys[i], &b = keys[i + 1];
  const double s = share, s2 = s * s, s3 = s2 * s, span = b.at - a.at;
  const glm::dvec3 center =
      (2 * s3 - 3 * s2 + 1) * a.center + (3 * s2 - 2 * s3) * b.center +
      span * ((s3 - 2 * s2 + s) * Tangent(keys, i) + (s3 - s2) * Tangent(keys, i + 1));
  const glm::dquat turn = glm::normalize(glm::slerp(a.world_from_cam, b.world_from_cam, share));
  return Rigid3{glm::mat3_cast(turn), center}.Inverse();
}

}  // namespace

std::vector<Rigid3> OrbitPath(const Scene& scene, const std::vector<int>& views, size_t frames) {
  TETREC_CHECK(!views.empty(), "an orbit starts from a camera");
  const glm::dvec3 subject = scene.subject_bounds.Center();
  std::vector<double> heights, distances;
  for (const int view : views) {
    const glm::dvec3 offset = CenterOf(scene.views[size_t(view)]) - subject;
    heights.push_back(offset.z);
    distances.push_back(std::hypot(offset.x, offset.y));
  }
  const double height = Quantile(heights, 0.5);
  // Cameras straight above the subject give no circle; then it is as wide as the subject.
  const double radius = std::max(Quantile(distances, 0.5), 0.5 * scene.subject_bounds.Size().x);
  const glm::dvec3 first = CenterOf(scene.views[size_t(views.front())]) - subject;
  const double start = std::atan2(first.y, first.x);
  std::vector<Rigid3> path;
  for (size_t i = 0; i < frames; ++i) {
    const double turn = start + 2 * std::numbers::pi * double(i) / double(frames);
    const glm::dvec3 offset(radius * std::cos(turn), radius * std::sin(turn), height);
    path.push_back(CamLookingAt(subject + offset, subject));
  }
  return path;
}

std::vector<Rigid3> PathThroughCameras(const Scene& scene, const std::vector<int>& views,
                                       size_t frames) {
  TETREC_CHECK(views.size() >= 2, "a path leads from one camera to another");
  const std::vector<Key> keys = KeysOf(scene, views);
  std::vector<Rigid3> path;
  size_t i = 0;
  for (size_t frame = 0; frame < frames; ++frame) {
    const double share = frames > 1 ? double(frame) / double(frames - 1) : 0;
    const double at = share * keys.back().at;
    while (i + 2 < keys.size() && keys[i + 1].at <= at) ++i;
    path.push_back(Between(keys, i, (at - keys[i].at) / (keys[i + 1].at - keys[i].at)));
  }
  return path;
}

Camera VideoCamera(const Camera& camera, int size) {
  const int longer = std::max(camera.width, camera.height);
  const double scale = size > 0 ? double(size) / longer : 1;
  const auto even = [&](int side) { return std::max(2, 2 * int(std::lround(scale * side / 2))); };
  return camera.Resized(even(camera.width), even(camera.height));
}

}  // namespace tetrec
