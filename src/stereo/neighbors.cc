// Which views are matched with which, and between which depths.
#include "stereo/neighbors.h"

#include "core/parallel.h"
#include "core/quantile.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrec {
namespace {

constexpr size_t kFewestSparsePoints = 50;
constexpr size_t kFewestSeenPoints = 5;
constexpr int kGridCells = 10;

// Photos from within this share of the distance to what they show (0.6 degrees) are as good as one:
// nothing between them shows depth, and their maps agree also where they are wrong.
constexpr double kOnePlace = 0.01;

double AngleScore(double angle) {
  constexpr double kBest = glm::pi<double>() / 18;  // 10 degrees
  const double width = angle < kBest ? kBest / 2 : kBest;
  return std::exp(-(angle - kBest) * (angle - kBest) / (2 * width * width));
}

bool Shows(const StereoView& view, const glm::dvec3& point) {
  return view.camera.Shows(view.cam_from_world * point);
}

// What a point that both cameras see says for the pair.
double PointScore(const glm::dvec3& first, const glm::dvec3& second, const glm::dvec3& point) {
  const glm::dvec3 a = first - point, b = second - point;
  const double la = glm::length(a), lb = glm::length(b);
  const double cosine = std::clamp(glm::dot(a, b) / (la * lb), -1.0, 1.0);
  return AngleScore(std::acos(cosine)) * std::min(la, lb) / std::max(la, lb);
}

// What a view sees of the points.
struct Sight {
  glm::dvec3 center{0.0};
  double median_distance = 0;  // from the centre to the points that it sees; 0 if it sees none
  std::vector<uint8_t> seen;   // 1 or 0 for each of the points that pairs are judged by
};

// Pairs are judged by every `step`-th point. (A byte for each view and point could fill the
// memory.)
Sight SightOf(const StereoView& view, std::span<const glm::dvec3> points, size_t step) {
  Sight sight;
  sight.center = view.cam_from_world.Inverse().translation;
  std::vector<double> distances;
  for (size_t p = 0; p < points.size(); ++p) {
    const bool is_seen = Shows(view, points[p]);
    if (is_seen) distances.push_back(glm::distance(sight.center, points[p]));
    if (p % step == 0) sight.seen.push_back(is_seen ? 1 : 0);
  }
  if (!distances.empty()) sight.median_distance = Quantile(std::move(distances), 0.5);
  return sight;
}

// The depths of a box's corners that are in front of the camera.
DepthRange RangeOfBox(const StereoView& view, const Bounds3& box) {
  DepthRange range{INFINITY, 0};
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner((i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y,
                            (i & 4 ? box.max : box.min).z);
    const double z = (view.cam_from_world * corner).z;
    range.nearest = std::min(range.nearest, z);
    range.farthest = std::max(range.farthest, z);
  }
  range.nearest = std::max(range.nearest, 0.02 * range.farthest);
  return range;
}

}  // namespace

std::vector<glm::dvec3> OverlapPoints(const Scene& scene) {
  std::vector<glm::dvec3> points;
  for (const ScenePoint& point : scene.points) points.push_back(point.position);
  if (points.size() >= kFewestSparsePoints) return points;
  points.clear();
  const Bounds3& box = scene.subject_bounds;
  for (int z = 0; z < kGridCells; ++z) {
    for (int y = 0; y < kGridCells; ++y) {
      for (int x = 0; x < kGridCells; ++x) {
        points.push_back(box.min + (glm::dvec3(x, y, z) + 0.5) / double(kGridCells) * box.Size());
      }
    }
  }
  return points;
}

std::vector<std::vector<uint32_t>> ChooseNeighbors(std::span<const StereoView> views,
                                                   std::span<const glm::dvec3> points,
                                                   size_t count) {
  // Of many points a share says the same.
  const size_t step = 1 + points.size() / 2000;
  std::vector<Sight> sights(views.size());
  ParallelFor(views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) sights[i] = SightOf(views[i], points, step);
  });
  std::vector<std::vector<uint32_t>> neighbors(views.size());
  ParallelFor(views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      std::vector<std::pair<double, uint32_t>> scores;
      for (size_t j = 0; j < views.size(); ++j) {
        double score = 0;
        for (size_t s = 0; s < sights[i].seen.size() && i != j; ++s) {
          if (!sights[i].seen[s] || !sights[j].seen[s]) continue;
          score += PointScore(sights[i].center, sights[j].center, points[s * step]);
        }
        if (score > 0) scores.emplace_back(-score, uint32_t(j));
      }
      std::sort(scores.begin(), scores.end());
      const double one_place = kOnePlace * sights[i].median_distance;
      std::vector<glm::dvec3> taken{sights[i].center};
      for (const auto& [score, j] : scores) {
        if (neighbors[i].size() == count) break;
        const glm::dvec3& center = sights[j].center;
        const bool is_taken = std::ranges::any_of(taken, [&](const glm::dvec3& other) {
          return glm::distance(center, other) < one_place;
        });
        if (is_taken) continue;
        neighbors[i].push_back(j);
        taken.push_back(center);
      }
    }
  });
  return neighbors;
}

DepthRange FindDepthRange(const StereoView& view, std::span<const glm::dvec3> points,
                          const Scene& scene) {
  if (scene.has_alpha) return RangeOfBox(view, scene.subject_bounds.Scaled(1.02));
  std::vector<double> depths;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 in_cam = view.cam_from_world * point;
    if (view.camera.Shows(in_cam)) depths.push_back(in_cam.z);
  }
  if (depths.size() < kFewestSeenPoints) return {};
  // The points are where texture is; surfaces without it may be nearer. Few points lie in the
  // background: what is farther than every plane would match some nearer one by chance.
  constexpr double kNearer = 0.75, kFarther = 8;
  return {kNearer * Quantile(depths, 0.01), kFarther * Quantile(depths, 0.98)};
}

}  // namespace tetrec
