// Small scenes with images in closed form, for tests: no mesh, renderer or file is needed.
#pragma once

#include "image/image.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

// All are in scene coordinates: centre 0, subject within [-1, 1]^3.
enum class SyntheticKind {
  kBall,      // an opaque textured ball, alpha around it
  kTwoBalls,  // two balls of different size that occlude each other; alpha around them
  kFog,       // a ball of constant density whose colour is linear in position; alpha around it
  kRoom,      // the ball in the middle of a textured room [-4, 4]^3, opaque as a photo
};

struct SyntheticOptions {
  SyntheticKind kind = SyntheticKind::kBall;
  int train_views = 24, validation_views = 4, test_views = 4;  // kRoom trains on validation views
  int width = 64, height = 64;                                 // [px]
  int rays_per_side = 3;  // squared: rays averaged in a pixel, on a regular grid
  int points = 0;         // sparse points on surfaces that at least 2 training views see (not kFog)
  uint64_t seed = 1;      // texture, camera positions, points
};

struct SyntheticScene {
  Scene scene;
  std::vector<Image> images;  // one per view; RGB for kRoom, otherwise RGBA
};

SyntheticScene MakeSyntheticScene(const SyntheticOptions& options);
// Writes images, scene.json and points.ply, as the first stage would.
void WriteSyntheticScene(const std::filesystem::path& folder, const SyntheticScene& synthetic);

// Colour and opacity along one ray.
struct RaySample {
  glm::dvec3 premultiplied_srgb{0.0};  // [0, 1], times alpha
  double alpha = 0;
};
RaySample SampleSynthetic(const SyntheticOptions& options, const glm::dvec3& origin_in_world,
                          const glm::dvec3& direction_in_world);

// The subject is the inside of the scene's balls (of kRoom, the ball in its middle).
bool IsInSubject(SyntheticKind kind, const glm::dvec3& point_in_world);

constexpr double kFogDensity = 2.5;  // density of kFog [1 / world unit]

}  // namespace tetrec
