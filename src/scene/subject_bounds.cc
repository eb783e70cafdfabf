// Where the subject is.
#include "scene/subject_bounds.h"

#include "core/error.h"
#include "core/quantile.h"
#include "geometry/rotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>

namespace tetrec {
namespace {

// A subject is in most images; what is behind it differs from side to side.
constexpr double kCommonShare = 0.6;  // of the share of views that see the best-seen points
// The subject does not extend to the cameras.
constexpr double kReach = 0.75;    // of the median distance from camera to focus
constexpr double kTrimmed = 0.01;  // of the weight, at each end of each axis
constexpr double kMargin = 0.05;   // of the longest side, at each side
// What nearly all views show belongs to the subject, however few points it has (the end of a thin
// part), if the points are not alone, as outliers are.
constexpr double kNearlyAllShare = 0.9;  // of the share of views that see the best-seen points
constexpr size_t kFewestInGroup = 5;     // such points, within the margin
constexpr double kFarthest = 1e9;        // of given bounds
// Cameras that all look in one direction but turn about it look straight down: a drone turns
// between strips, while people keep their photos upright. Lengths of mean unit vectors.
constexpr double kOneDirection = 0.95, kManyHeadings = 0.3;
// Cameras that look in one direction from places so far apart survey what they see: by a drone, or
// along a facade. A few steps to the side before a shelf are not a survey.
constexpr double kSurveySpread = 0.3;  // of the median depth: RMS distance of axes from the focus
constexpr double kFarInSurvey = 3;     // times the median depth: distance from the nearest camera
constexpr uint32_t kLeastTrack = 3;    // of a survey's points

glm::dvec3 CenterOf(const View& view) { return view.cam_from_world.Inverse().translation; }
glm::dvec3 AxisInWorld(const View& view, int axis) {
  return glm::transpose(view.cam_from_world.rotation)[axis];
}

double ShareOfViews(const Scene& scene, const glm::dvec3& point) {
  size_t seen = 0;
  for (const View& view : scene.views) {
    seen += scene.cameras[size_t(view.camera)].Shows(view.cam_from_world * point);
  }
  return double(seen) / double(scene.views.size());
}

double MedianDepth(const Scene& scene, const View& view) {
  std::vector<double> depths;
  for (const ScenePoint& point : scene.points) {
    const glm::dvec3 in_cam = view.cam_from_world * point.position;
    if (scene.cameras[size_t(view.camera)].Shows(in_cam)) depths.push_back(in_cam.z);
  }
  return depths.empty() ? 0 : Quantile(std::move(depths), 0.5);
}

glm::dvec3 MeanAxis(std::span<const View> views, int axis) {
  glm::dvec3 mean(0.0);
  for (const View& view : views) mean += AxisInWorld(view, axis) / double(views.size());
  return mean;
}

// The median depth of the points if the cameras survey what they see, nothing otherwise: their axes
// pass far beside each other. Those of photos around a subject, or of a walk forward, do not.
std::optional<double> DepthOfSurvey(const Scene& scene, const glm::dvec3& focus) {
  if (glm::length(MeanAxis(scene.views, 2)) <= kOneDirection) return std::nullopt;
  double square = 0;
  std::vector<double> depths;
  for (const View& view : scene.views) {
    const glm::dvec3 beside = glm::cross(focus - CenterOf(view), AxisInWorld(view, 2));
    square += glm::dot(beside, beside) / double(scene.views.size());
    const double depth = MedianDepth(scene, view);
    if (depth > 0) depths.push_back(depth);
  }
  if (depths.empty()) return std::nullopt;
  const double depth = Quantile(std::move(depths), 0.5);
  return std::sqrt(square) > kSurveySpread * depth ? std::optional(depth) : std::nullopt;
}

struct SubjectPoint {
  const ScenePoint* point = nullptr;
  bool nearly_all_see_it = false;
};

// In a survey, only what is far from all cameras is background.
std::vector<SubjectPoint> SurveyedPoints(const Scene& scene, double depth) {
  std::vector<glm::dvec3> centers;
  for (const View& view : scene.views) centers.push_back(CenterOf(view));
  std::vector<SubjectPoint> near, all;
  for (const ScenePoint& point : scene.points) {
    all.push_back({&point, false});
    const bool is_reliable =
        point.track_length == 0 /* not known */ || point.track_length >= kLeastTrack;
    const bool is_near = std::ranges::any_of(centers, [&](const glm::dvec3& center) {
      return glm::distance(point.position, center) <= kFarInSurvey * depth;
    });
    if (is_reliable && is_near) near.push_back(all.back());
  }
  return near.size() < kFewPoints ? all : near;
}

std::vector<SubjectPoint> SubjectPoints(const Scene& scene, const glm::dvec3& focus) {
  if (const auto depth = DepthOfSurvey(scene, focus)) return SurveyedPoints(scene, *depth);
  std::vector<double> distances, shares;
  for (const View& view : scene.views) distances.push_back(glm::distance(CenterOf(view), focus));
  const double reach = kReach * Quantile(distances, 0.5);
  std::vector<const ScenePoint*> near;
  for (const ScenePoint& point : scene.points) {
    if (glm::distance(point.position, focus) <= reach) near.push_back(&point);
  }
  // If the cameras look from inside out, or there are hardly any points, all of them count.
  if (near.size() < kFewPoints) {
    near.clear();
    for (const ScenePoint& point : scene.points) near.push_back(&point);
  }
  for (const ScenePoint* point : near) shares.push_back(ShareOfViews(scene, point->position));
  const double best = Quantile(shares, 0.95);
  std::vector<SubjectPoint> common, all;
  for (size_t i = 0; i < near.size(); ++i) {
    all.push_back({near[i], shares[i] >= kNearlyAllShare * best});
    if (shares[i] >= kCommonShare * best) common.push_back(all.back());
  }
  return common.size() < kFewPoints ? all : common;
}

// The box without the thin ends of each axis, which outliers reach.
Bounds3 TrimmedBox(const std::vector<SubjectPoint>& points, const glm::dmat3& upright_from_input) {
  Bounds3 box;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<std::pair<double, double>> weighted;
    for (const auto& [point, nearly_all] : points) {
      weighted.push_back({(upright_from_input * point->position)[axis],
                          double(std::max(1u, point->track_length))});
    }
    box.min[axis] = WeightedQuantile(weighted, kTrimmed);
    box.max[axis] = WeightedQuantile(weighted, 1 - kTrimmed);
  }
  return box;
}

// Points by cells of a grid, to find those near to a place.
class PointCells {
 public:
  PointCells(const std::vector<glm::dvec3>& points, double reach) : reach_(reach) {
    for (const glm::dvec3& point : points) cells_[CellOf(point)].push_back(point);
  }

  // True if `count` points or more are within reach of the place.
  bool HasWithinReach(const glm::dvec3& place, size_t count) const {
    size_t found = 0;
    const Cell middle = CellOf(place);
    for (int neighbor = 0; neighbor < 27; ++neighbor) {
      const auto cell = cells_.find({middle[0] + neighbor % 3 - 1, middle[1] + neighbor / 3 % 3 - 1,
                                     middle[2] + neighbor / 9 - 1});
      if (cell == cells_.end()) continue;
      for (const glm::dvec3& point : cell->second) {
        found += glm::distance(place, point) <= reach_;
        if (found == count) return true;
      }
    }
    return false;
  }

 private:
  using Cell = std::array<int64_t, 3>;

  // A little longer than the reach, so that rounding hides no neighbour.
  Cell CellOf(const glm::dvec3& point) const {
    constexpr double kSide = 1.001, kFarthestCell = 1e18;
    const glm::dvec3 cell = glm::floor(point / (kSide * reach_));
    const glm::dvec3 near = glm::clamp(cell, -kFarthestCell, kFarthestCell);
    return {int64_t(near.x), int64_t(near.y), int64_t(near.z)};
  }

  double reach_;
  std::map<Cell, std::vector<glm::dvec3>> cells_;
};

// The box grown to the groups of points that nearly all views see.
Bounds3 WithWellSeenGroups(const Bounds3& box, const std::vector<SubjectPoint>& points,
                           const glm::dmat3& upright_from_input, double reach) {
  std::vector<glm::dvec3> well_seen;
  for (const auto& [point, nearly_all] : points) {
    if (nearly_all) well_seen.push_back(upright_from_input * point->position);
  }
  const PointCells cells(well_seen, reach);
  Bounds3 grown = box;
  for (const glm::dvec3& p : well_seen) {
    if (!grown.Contains(p) && cells.HasWithinReach(p, kFewestInGroup)) grown.Add(p);
  }
  return grown;
}

double LongestSide(const Bounds3& box) {
  const glm::dvec3 size = box.Size();
  return std::max({size.x, size.y, size.z});
}

// Its columns are the world's x, y and z in the input's frame; x is the first camera's x axis, made
// level.
glm::dmat3 UprightFrame(const Scene& scene, const glm::dvec3& up) {
  glm::dvec3 x = AxisInWorld(scene.views.front(), 0);
  if (glm::length(glm::cross(x, up)) < 1e-3) x = AxisInWorld(scene.views.front(), 2);
  x = glm::normalize(x - glm::dot(x, up) * up);
  return NearestRotation(glm::dmat3(x, glm::cross(up, x), up));
}

}  // namespace

glm::dvec3 FindFocus(const Scene& scene) {
  TETREC_CHECK(!scene.views.empty(), "no views");
  // Along its own axis a camera pulls, weakly, towards the median depth of its points.
  constexpr double kAlongAxis = 0.05;
  struct Look {
    glm::dvec3 center, axis;
    double depth;
  };
  std::vector<Look> looks;
  for (const View& view : scene.views)
    looks.push_back({CenterOf(view), AxisInWorld(view, 2), MedianDepth(scene, view)});

  std::vector<double> weights(looks.size(), 1.0);
  glm::dvec3 focus(0.0);
  // Iteratively reweighted least squares converge to the least sum of distances.
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    glm::dmat3 a(0.0);
    glm::dvec3 b(0.0);
    for (size_t i = 0; i < looks.size(); ++i) {
      const glm::dmat3 along = glm::outerProduct(looks[i].axis, looks[i].axis);
      const glm::dmat3 across = glm::dmat3(1.0) - along;
      a += weights[i] * (across + kAlongAxis * along);
      b += weights[i] * (across * looks[i].center +
                         kAlongAxis * (along * looks[i].center + looks[i].depth * looks[i].axis));
    }
    focus = glm::inverse(a) * b;
    std::vector<double> distances;
    for (const Look& look : looks) {
      distances.push_back(glm::length(glm::cross(focus - look.center, look.axis)));
    }
    const double typical = std::max(Quantile(distances, 0.5), 1e-12);
    for (size_t i = 0; i < looks.size(); ++i)
      weights[i] = typical / std::max(distances[i], typical);
  }
  return focus;
}

glm::dvec3 FindUp(std::span<const View> views) {
  const glm::dvec3 mean_ahead = MeanAxis(views, 2);
  glm::dvec3 mean_up = -MeanAxis(views, 1);
  if (glm::length(mean_ahead) > kOneDirection && glm::length(mean_up) < kManyHeadings) {
    return -glm::normalize(mean_ahead);
  }
  if (glm::length(mean_up) < 1e-6) mean_up = -AxisInWorld(views.front(), 1);
  mean_up = glm::normalize(mean_up);
  // Two level axes are perpendicular to the upright direction; the length of their cross product,
  // the sine of the angle between them, weights it.
  glm::dvec3 up(0.0);
  for (size_t i = 0; i < views.size(); ++i) {
    for (size_t k = i + 1; k < views.size(); ++k) {
      const glm::dvec3 normal = glm::cross(AxisInWorld(views[i], 0), AxisInWorld(views[k], 0));
      up += glm::dot(normal, mean_up) < 0 ? -normal : normal;
    }
  }
  constexpr double kTrustInMean = 0.05;
  const auto pairs = double(views.size() * (views.size() - 1)) / 2;
  return glm::normalize(up + kTrustInMean * std::max(pairs, 1.0) * mean_up);
}

Subject FindSubject(const Scene& scene) {
  if (scene.points.empty() || scene.views.empty())
    throw DataError("there are no points from which to find the subject");
  Subject subject;
  subject.focus_in_input = FindFocus(scene);
  subject.up_in_input = FindUp(scene.views);
  const glm::dmat3 input_from_upright = UprightFrame(scene, subject.up_in_input);
  const glm::dmat3 upright_from_input = glm::transpose(input_from_upright);

  const std::vector<SubjectPoint> points = SubjectPoints(scene, subject.focus_in_input);
  const Bounds3 trimmed = TrimmedBox(points, upright_from_input);
  const double longest = LongestSide(trimmed);
  if (!(longest > 0)) throw DataError("all points of the subject are in one place");
  // A margin for parts without points; a flat subject becomes a thin box, not an empty one.
  const glm::dvec3 margin(kMargin * longest);
  Bounds3 box = WithWellSeenGroups(trimmed, points, upright_from_input, kMargin * longest);
  box = {box.min - margin, box.max + margin};

  const double scale = LongestSide(box) / 2;
  subject.input_from_world = {scale, input_from_upright, input_from_upright * box.Center()};
  subject.bounds_in_world = {-box.Size() / (2 * scale), box.Size() / (2 * scale)};
  subject.points = points.size();
  for (const auto& [point, nearly_all] : points) {
    subject.outside += !box.Contains(upright_from_input * point->position);
  }
  return subject;
}

namespace {

void MoveWorld(Scene& scene, const Similarity3& old_from_new) {
  const Similarity3 new_from_old = old_from_new.Inverse();
  for (View& view : scene.views)
    view.cam_from_world = CamFromWorld(view.cam_from_world, old_from_new);
  for (ScenePoint& point : scene.points) point.position = new_from_old * point.position;
}

}  // namespace

void MoveToSubject(Scene& scene, const Subject& subject) {
  MoveWorld(scene, subject.input_from_world);
  scene.input_from_world = subject.input_from_world;
  scene.subject_bounds = subject.bounds_in_world;
}

void MoveToBox(Scene& scene, const Bounds3& box_in_world) {
  const double scale = LongestSide(box_in_world) / 2;
  const Similarity3 old_from_new{scale, glm::dmat3(1.0), box_in_world.Center()};
  MoveWorld(scene, old_from_new);
  scene.input_from_world = scene.input_from_world * old_from_new;
  scene.subject_bounds = {-box_in_world.Size() / (2 * scale), box_in_world.Size() / (2 * scale)};
}

void CheckGivenBounds(const Bounds3& bounds) {
  const auto& [min, max] = bounds;
  const bool is_box = glm::all(glm::lessThan(min, max)) &&
                      glm::all(glm::lessThan(glm::abs(min), glm::dvec3(kFarthest))) &&
                      glm::all(glm::lessThan(glm::abs(max), glm::dvec3(kFarthest)));
  if (is_box) return;
  throw UsageError(
      fmt::format("bounds is {},{},{},{},{},{}; expected x0,y0,z0,x1,y1,z1 with x0 < x1, "
                  "y0 < y1, z0 < z1 and absolute values below {}",
                  min.x, min.y, min.z, max.x, max.y, max.z, kFarthest));
}

}  // namespace tetrec
