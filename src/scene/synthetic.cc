// Analytic scenes.
#include "scene/synthetic.h"

#include "core/error.h"
#include "core/parallel.h"
#include "geometry/look_at.h"
#include "geometry/random_vectors.h"
#include "scene/supersampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace tetrec {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRoomHalfSide = 4.0;
constexpr double kCameraDistance = 3.0;

struct Ball {
  glm::dvec3 center;
  double radius;
};
constexpr Ball kOneBall[] = {{{0, 0, 0}, 0.9}};
constexpr Ball kPair[] = {{{-0.45, 0.1, 0}, 0.5}, {{0.55, -0.1, 0.15}, 0.35}};

std::span<const Ball> Balls(SyntheticKind kind) {
  return kind == SyntheticKind::kTwoBalls ? std::span<const Ball>(kPair) : kOneBall;
}

// Three sine waves through space per channel, with values between 0.05 and 0.95.
struct Texture {
  struct Wave {
    glm::dvec3 frequency;
    double phase;
  };
  std::array<std::array<Wave, 3>, 3> waves;

  glm::dvec3 At(const glm::dvec3& point) const {
    glm::dvec3 color(0.5);
    for (int c = 0; c < 3; ++c) {
      for (const Wave& wave : waves[size_t(c)]) {
        color[c] += 0.15 * std::sin(glm::dot(wave.frequency, point) + wave.phase);
      }
    }
    return color;
  }
};

Texture MakeTexture(uint64_t seed) {
  MersenneRandom random(seed);
  Texture texture{};
  for (auto& channel : texture.waves) {
    double length = 2.0;
    for (Texture::Wave& wave : channel) {
      wave.frequency = length * RandomDirection(random);
      wave.phase = 2 * kPi * random.Uniform();
      length *= 2;
    }
  }
  return texture;
}

// Colour of the fog at a point; linear in position, and in [0.05, 0.95] within the ball.
glm::dvec3 FogColor(const glm::dvec3& point) {
  return glm::dvec3(0.5) + 0.5 * glm::dvec3(point.x, point.y, point.z);
}

// Ray parameters at which a line enters and leaves a ball.
struct Chord {
  double enter, leave;
};
std::optional<Chord> Intersect(const Ball& ball, const glm::dvec3& origin,
                               const glm::dvec3& unit_direction) {
  const glm::dvec3 to_center = ball.center - origin;
  const double middle = glm::dot(to_center, unit_direction);
  // The rejected vector gives the distance to the line without the cancellation in |c|^2 -
  // middle^2.
  const glm::dvec3 rejection = to_center - middle * unit_direction;
  const double half_squared = ball.radius * ball.radius - glm::dot(rejection, rejection);
  if (half_squared <= 0) return std::nullopt;
  const double half = std::sqrt(half_squared);
  return Chord{middle - half, middle + half};
}

// Ray parameter of the first opaque surface in front of the origin.
std::optional<double> FirstHit(SyntheticKind kind, const glm::dvec3& origin,
                               const glm::dvec3& unit_direction) {
  std::optional<double> first;
  for (const Ball& ball : Balls(kind)) {
    const std::optional<Chord> chord = Intersect(ball, origin, unit_direction);
    if (chord && chord->enter > 0 && (!first || chord->enter < *first)) first = chord->enter;
  }
  if (first || kind != SyntheticKind::kRoom) return first;
  double wall = INFINITY;  // seen from inside: the nearest of the three walls ahead
  for (int axis = 0; axis < 3; ++axis) {
    const double ahead = std::copysign(kRoomHalfSide, unit_direction[axis]);
    if (unit_direction[axis] != 0) {
      wall = std::min(wall, (ahead - origin[axis]) / unit_direction[axis]);
    }
  }
  return wall;
}

// Constant density, linear colour: C = c0 (1 - M) + c1 (M - T) with M = (1 - T) / tau.
RaySample SampleFog(const glm::dvec3& origin, const glm::dvec3& unit_direction) {
  const std::optional<Chord> chord = Intersect(kOneBall[0], origin, unit_direction);
  if (!chord) return {};
  const double tau = kFogDensity * (chord->leave - chord->enter);
  const double transmittance = std::exp(-tau);
  const double mean = tau > 0 ? -std::expm1(-tau) / tau : 1.0;
  const glm::dvec3 near = FogColor(origin + chord->enter * unit_direction);
  const glm::dvec3 far = FogColor(origin + chord->leave * unit_direction);
  return {near * (1 - mean) + far * (mean - transmittance), 1 - transmittance};
}

RaySample Sample(SyntheticKind kind, const Texture& texture, const glm::dvec3& origin,
                 const glm::dvec3& unit_direction) {
  if (kind == SyntheticKind::kFog) return SampleFog(origin, unit_direction);
  const std::optional<double> hit = FirstHit(kind, origin, unit_direction);
  if (!hit) return {};
  return {texture.At(origin + *hit * unit_direction), 1.0};
}

// Adds `count` views spread evenly over a sphere except its poles (a Fibonacci lattice turned by
// `turn`).
void AddViews(Scene& scene, Split split, int count, double turn) {
  const double golden_angle = kPi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 0.9 * (1 - (2.0 * i + 1) / count), r = std::sqrt(1 - z * z);
    const double angle = golden_angle * i + turn;
    View view;
    view.name = fmt::format("{}/{:03}", Name(split), i);
    view.image = fmt::format("images/{}.png", view.name);
    view.split = split;
    view.cam_from_world = CamLookingAt(
        kCameraDistance * glm::dvec3(r * std::cos(angle), r * std::sin(angle), z), glm::dvec3(0.0));
    scene.views.push_back(std::move(view));
  }
}

Image RenderView(const SyntheticOptions& options, const Texture& texture, const Camera& camera,
                 const Rigid3& cam_from_world) {
  const bool has_alpha = options.kind != SyntheticKind::kRoom;
  return RenderSupersampled(camera, cam_from_world, options.rays_per_side, has_alpha,
                            [&](const glm::dvec3& origin, const glm::dvec3& direction) {
                              return Sample(options.kind, texture, origin, direction);
                            });
}

bool Sees(const Camera& camera, const Rigid3& cam_from_world, SyntheticKind kind,
          const glm::dvec3& point) {
  if (!camera.Shows(cam_from_world * point)) return false;
  const glm::dvec3 origin = cam_from_world.Inverse().translation;
  const double distance = glm::length(point - origin);
  const std::optional<double> hit = FirstHit(kind, origin, (point - origin) / distance);
  return hit && *hit > distance * (1 - 1e-9);
}

// Adds points where random rays of random training views end, so that they are dense where the
// cameras look, like those of structure from motion.
void AddPoints(const SyntheticOptions& options, const Texture& texture, MersenneRandom& random,
               Scene& scene) {
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  const Camera& camera = scene.cameras[0];
  while (int(scene.points.size()) < options.points) {
    const size_t chosen = size_t(random.Uniform() * double(training.size()));
    const double x = random.Uniform() * camera.width, y = random.Uniform() * camera.height;
    const Rigid3 world_from_cam = scene.views[size_t(training[chosen])].cam_from_world.Inverse();
    const glm::dvec3 direction =
        glm::normalize(world_from_cam.rotation * camera.CamFromImage({x, y}));
    const std::optional<double> hit = FirstHit(options.kind, world_from_cam.translation, direction);
    if (!hit) continue;
    ScenePoint point;
    point.position = world_from_cam.translation + *hit * direction;
    for (const int i : training) {
      const View& view = scene.views[size_t(i)];
      point.track_length += Sees(camera, view.cam_from_world, options.kind, point.position) ? 1 : 0;
    }
    if (point.track_length < 2) continue;
    const glm::dvec3 color = texture.At(point.position);
    for (int c = 0; c < 3; ++c) point.color_srgb[size_t(c)] = uint8_t(std::lround(255 * color[c]));
    point.reprojection_error_px = 0;
    scene.points.push_back(point);
  }
}

void CheckOptions(const SyntheticOptions& options) {
  TETREC_CHECK(options.train_views >= 2 && options.validation_views >= 0 && options.test_views >= 0,
               "views of a synthetic scene");
  TETREC_CHECK(options.width > 0 && options.height > 0 && options.rays_per_side > 0,
               "pictures of a synthetic scene");
  TETREC_CHECK(options.points == 0 || options.kind != SyntheticKind::kFog,
               "fog has no surface for points");
}

}  // namespace

SyntheticScene MakeSyntheticScene(const SyntheticOptions& options) {
  CheckOptions(options);
  const bool is_room = options.kind == SyntheticKind::kRoom;
  const Texture texture = MakeTexture(options.seed);
  MersenneRandom random(options.seed + 1);

  SyntheticScene synthetic;
  Scene& scene = synthetic.scene;
  // The shorter side shows 46 degrees: a ball of 1.24 around the centre.
  const double focal_px = 1.2 * std::min(options.width, options.height);
  scene.cameras = {{options.width, options.height, focal_px, focal_px, 0.5 * options.width,
                    0.5 * options.height}};
  scene.background = is_room ? Background::kScene : Background::kWhite;
  scene.has_alpha = !is_room;
  scene.subject_bounds = {glm::dvec3(-1.0), glm::dvec3(1.0)};
  const int validation_views = is_room ? 0 : options.validation_views;
  const int train_views = options.train_views + options.validation_views - validation_views;
  AddViews(scene, Split::kTrain, train_views, 2 * kPi * random.Uniform());
  AddViews(scene, Split::kValidation, validation_views, 2 * kPi * random.Uniform());
  AddViews(scene, Split::kTest, options.test_views, 2 * kPi * random.Uniform());
  AddPoints(options, texture, random, scene);

  synthetic.images.resize(scene.views.size());
  ParallelFor(scene.views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      synthetic.images[i] =
          RenderView(options, texture, scene.cameras[0], scene.views[i].cam_from_world);
    }
  });
  return synthetic;
}

void WriteSyntheticScene(const std::filesystem::path& folder, const SyntheticScene& synthetic) {
  for (size_t i = 0; i < synthetic.images.size(); ++i) {
    const std::filesystem::path path = folder / synthetic.scene.views[i].image;
    std::filesystem::create_directories(path.parent_path());
    WriteImage(path, synthetic.images[i]);
  }
  WriteScene(folder, synthetic.scene);
}

RaySample SampleSynthetic(const SyntheticOptions& options, const glm::dvec3& origin_in_world,
                          const glm::dvec3& direction_in_world) {
  return Sample(options.kind, MakeTexture(options.seed), origin_in_world,
                glm::normalize(direction_in_world));
}

bool IsInSubject(SyntheticKind kind, const glm::dvec3& point_in_world) {
  const std::span<const Ball> balls = Balls(kind);
  return std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) {
    return glm::length(point_in_world - ball.center) < ball.radius;
  });
}

}  // namespace tetrec
