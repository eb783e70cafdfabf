// Small scenes whose pictures have a closed form, for tests: no mesh, no renderer, no file needed.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

// All in our world: centre 0, subject within [-1, 1]^3.
enum class SyntheticKind {
  kBall,      // an opaque textured ball, alpha around it
  kTwoBalls,  // two of different size, which hide each other; alpha around them
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
  std::vector<Image> images;  // one a view; RGB for kRoom, else RGBA
};

SyntheticScene MakeSyntheticScene(const SyntheticOptions& options);
// Pictures, scene.json and points.ply: what the first stage would have written.
void WriteSyntheticScene(const std::filesystem::path& folder, const SyntheticScene& synthetic);

// What one ray sees.
struct RaySample {
  glm::dvec3 premultiplied_srgb{0.0};  // [0, 1], times alpha
  double alpha = 0;
};
RaySample SampleSynthetic(const SyntheticOptions& options, const glm::dvec3& origin_in_world,
                          const glm::dvec3& direction_in_world);

// The subject: inside a ball of the scene (kRoom: the ball in its middle).
bool IsInSubject(SyntheticKind kind, const glm::dvec3& point_in_world);

constexpr double kFogDensity = 2.5;  // [1 / world unit], of kFog

}  // namespace tetrec
