// The space in which the cameras stand and move.
#include "optimize/camera_space.h"

#include "core/parallel.h"
#include "scene/subject_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

constexpr size_t kNeighbors = 4;
// Radius of a capsule over the distance to the nearest points.
constexpr double kShareOfClearance = 0.5;
// Share of the points that may be stray ones, in the air.
constexpr double kStrayShare = 0.002;

double DistanceToLine(const glm::dvec3& point, const Capsule& line) {
  const glm::dvec3 along = line.b - line.a;
  const double length2 = glm::dot(along, along);
  const double share =
      length2 > 0 ? std::clamp(glm::dot(point - line.a, along) / length2, 0.0, 1.0) : 0.0;
  return glm::distance(point, line.a + share * along);
}

// The distance that all but the stray points keep from the line.
double Clearance(const Scene& scene, const Capsule& line) {
  std::vector<double> distances;
  for (const ScenePoint& point : scene.points) {
    distances.push_back(DistanceToLine(point.position, line));
  }
  const size_t stray = size_t(kStrayShare * double(distances.size()));
  std::nth_element(distances.begin(), distances.begin() + long(stray), distances.end());
  return distances[stray];
}

std::vector<glm::dvec3> TrainingCameras(const Scene& scene) {
  std::vector<glm::dvec3> centers_in_world;
  for (const int view : scene.ViewsOf(Split::kTrain)) {
    centers_in_world.push_back(scene.views[view].cam_from_world.Inverse().translation);
  }
  return centers_in_world;
}

std::vector<double> ClearanceOf(const Scene& scene, const std::vector<Capsule>& lines) {
  std::vector<double> clearance(lines.size());
  ParallelFor(lines.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) clearance[i] = Clearance(scene, lines[i]);
  });
  return clearance;
}

// From each camera to those of its nearest neighbours that are so near that the balls without
// points around both meet. A longer line may lead through a wall.
std::vector<Capsule> LinesBetween(const std::vector<glm::dvec3>& centers,
                                  const std::vector<double>& clearance) {
  std::vector<Capsule> lines;
  for (size_t i = 0; i < centers.size(); ++i) {
    std::vector<std::pair<double, size_t>> others;
    for (size_t j = 0; j < centers.size(); ++j) {
      if (j != i) others.emplace_back(glm::distance(centers[i], centers[j]), j);
    }
    std::sort(others.begin(), others.end());
    if (others.size() > kNeighbors) others.resize(kNeighbors);
    for (const auto& [distance, j] : others) {
      if (distance < clearance[i] + clearance[j]) lines.push_back({centers[i], centers[j], 0});
    }
  }
  return lines;
}

}  // namespace

std::vector<Capsule> FindCameraSpace(const Scene& scene) {
  if (scene.points.size() < kFewPoints) return {};
  const std::vector<glm::dvec3> centers = TrainingCameras(scene);
  std::vector<Capsule> capsules;
  for (const glm::dvec3& center : centers) capsules.push_back({center, center, 0});
  std::vector<double> clearance = ClearanceOf(scene, capsules);
  const std::vector<Capsule> lines = LinesBetween(centers, clearance);
  const std::vector<double> along = ClearanceOf(scene, lines);
  capsules.insert(capsules.end(), lines.begin(), lines.end());
  clearance.insert(clearance.end(), along.begin(), along.end());
  for (size_t i = 0; i < capsules.size(); ++i) {
    capsules[i].radius = kShareOfClearance * clearance[i];
  }
  return capsules;
}

std::vector<float> DistancesToCapsules(std::span<const glm::vec3> points,
                                       std::span<const Capsule> capsules) {
  std::vector<float> distances(points.size(), std::numeric_limits<float>::max());
  ParallelFor(points.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      for (const Capsule& capsule : capsules) {
        const double outside = DistanceToLine(glm::dvec3(points[i]), capsule) - capsule.radius;
        distances[i] = std::min(distances[i], float(std::max(0.0, outside)));
      }
    }
  });
  return distances;
}

std::vector<uint8_t> InsideCapsules(std::span<const glm::vec3> points,
                                    std::span<const Capsule> capsules) {
  std::vector<uint8_t> inside(points.size(), 0);
  ParallelFor(points.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      inside[i] = std::any_of(capsules.begin(), capsules.end(), [&](const Capsule& capsule) {
        return DistanceToLine(glm::dvec3(points[i]), capsule) < capsule.radius;
      });
    }
  });
  return inside;
}

}  // namespace tetrec
