// The space in which the cameras stand and move. It is empty, and pictures between the photos are
// taken there; but no photo forbids fog right in front of another photo's camera.
#pragma once

#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// All that is closer than `radius` to the line from `a` to `b` [world units].
struct Capsule {
  glm::dvec3 a{0.0}, b{0.0};
  double radius = 0;
};

// Capsules around the training cameras and between neighbouring ones. Their radii are shares of the
// distances to the nearest sparse points, so the points of a scene lie outside. None if the scene
// has fewer than kFewPoints points.
std::vector<Capsule> FindCameraSpace(const Scene& scene);

// For each point its distance to the nearest capsule; 0 inside, the largest float if there is none.
std::vector<float> DistancesToCapsules(std::span<const glm::vec3> points,
                                       std::span<const Capsule> capsules);

// For each point whether it is in one of the capsules.
std::vector<uint8_t> InsideCapsules(std::span<const glm::vec3> points,
                                    std::span<const Capsule> capsules);

}  // namespace tetrec
