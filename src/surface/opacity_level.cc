// The surface where cameras see it.
#include "surface/opacity_level.h"

#include "core/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

namespace tetrec {
namespace {

// A wider band averages more views and makes the surface smoother; a narrower one keeps thin parts
// and narrow gaps.
constexpr double kBand_px = 7;

// From this share of the band on, a camera counts the less the farther it sees the point behind its
// surface, because it may as well see something else in front of it, and may not close a gap.
constexpr double kFullWeight = 0.3;

// Depths of neighbouring pixels that differ by more footprints belong to different surfaces.
constexpr double kJump_px = 8;

// A cut is found when it is known to a share of its edge, or when the solidity there is below a
// hundredth of a band, or after some steps, which a jump of the solidity may need.
constexpr double kFinest = 1.0 / 256, kExact = 0.01;
constexpr int kMostSteps = 8;
constexpr double kKeep = 1e-3;  // of an edge, between a cut and the edge's ends
constexpr size_t kValuesPerTask = 256;

// Linear between the four pixel centres around a position, or that of the nearest centre where
// these show more than one surface. Infinite where the ray is never stopped.
double DepthAt(const SeenDepth& view, const glm::dvec2& pixel, double jump) {
  const int width = view.depth.width, height = view.depth.height;
  const glm::dvec2 place =
      glm::clamp(pixel - 0.5, glm::dvec2(0), glm::dvec2(width - 1.0, height - 1.0));
  const int x = int(place.x), y = int(place.y);
  const int x_right = std::min(x + 1, width - 1), y_below = std::min(y + 1, height - 1);
  const double right = place.x - x, down = place.y - y;
  const std::array<double, 4> depths = {view.depth.At(x, y), view.depth.At(x_right, y),
                                        view.depth.At(x, y_below), view.depth.At(x_right, y_below)};
  const auto [low, high] = std::minmax_element(depths.begin(), depths.end());
  if (*low != kNoDepth && *high - *low < jump) {
    return glm::mix(glm::mix(depths[0], depths[1], right), glm::mix(depths[2], depths[3], right),
                    down);
  }
  const double nearest = depths[size_t(2 * int(down > 0.5) + int(right > 0.5))];
  return nearest == kNoDepth ? std::numeric_limits<double>::infinity() : nearest;
}

// How far a point is behind where the ray through it is stopped, in bands. Nothing if it is outside
// of the image.
std::optional<double> BandsBehind(const glm::dvec3& point_in_world, const SeenDepth& view) {
  const glm::dvec3 in_cam = view.cam_from_world * point_in_world;
  if (!view.camera.Shows(in_cam)) return std::nullopt;
  const double footprint = in_cam.z / view.camera.fx;
  const double depth = DepthAt(view, view.camera.ImageFromCam(in_cam), kJump_px * footprint);
  return (in_cam.z - depth) / (kBand_px * footprint);
}

// A place on an edge, as the share of the way from its solid end to its free one.
struct PlaceOnEdge {
  double share, solidity;
};

// Searches between a solid and a free end by false position. An end that stays twice in a row
// counts half (the Illinois method), so that both close in on the cut.
double CutBetween(const glm::dvec3& solid, double solidity_of_solid, const glm::dvec3& free,
                  double solidity_of_free, std::span<const SeenDepth> views) {
  PlaceOnEdge low{0, solidity_of_solid}, high{1, solidity_of_free};
  const auto share_at_zero = [&] {
    return glm::mix(low.share, high.share, low.solidity / (low.solidity - high.solidity));
  };
  int last_sign = 0;
  for (int i = 0; i < kMostSteps && high.share - low.share > kFinest; ++i) {
    const double share = share_at_zero();
    const double solidity = SolidityAt(glm::mix(solid, free, share), views);
    const int sign = solidity > 0 ? 1 : -1;
    (sign > 0 ? low : high) = {share, solidity};
    if (std::abs(solidity) < kExact) return std::clamp(share, kKeep, 1 - kKeep);
    if (sign == last_sign) (sign > 0 ? high : low).solidity *= 0.5;
    last_sign = sign;
  }
  return std::clamp(share_at_zero(), kKeep, 1 - kKeep);
}

// The smallest id of the set of vertices that `v` belongs to, if sets are joined by JoinSets.
uint32_t SetOf(std::vector<uint32_t>& parents, uint32_t v) {
  while (parents[v] != v) v = parents[v] = parents[parents[v]];
  return v;
}

void JoinSets(std::vector<uint32_t>& parents, uint32_t a, uint32_t b) {
  a = SetOf(parents, a), b = SetOf(parents, b);
  parents[std::max(a, b)] = std::min(a, b);
}

// Marks the triangles without a mark whose connected patch fits into a box of this diagonal.
void MarkSmallPatches(const LevelSet& set, double largest_diagonal, std::vector<uint8_t>& marks) {
  std::vector<uint32_t> parents(set.positions.size());
  std::iota(parents.begin(), parents.end(), 0u);
  for (size_t f = 0; f < marks.size(); ++f) {
    if (marks[f]) continue;
    JoinSets(parents, set.triangles[f].x, set.triangles[f].y);
    JoinSets(parents, set.triangles[f].x, set.triangles[f].z);
  }
  std::vector<glm::vec3> lows = set.positions, highs = set.positions;
  for (uint32_t v = 0; v < parents.size(); ++v) {
    const uint32_t root = SetOf(parents, v);
    lows[root] = glm::min(lows[root], set.positions[v]);
    highs[root] = glm::max(highs[root], set.positions[v]);
  }
  for (size_t f = 0; f < marks.size(); ++f) {
    const uint32_t root = SetOf(parents, set.triangles[f].x);
    if (!marks[f]) marks[f] = glm::distance(lows[root], highs[root]) <= largest_diagonal;
  }
}

}  // namespace

double SolidityAt(const glm::dvec3& point_in_world, std::span<const SeenDepth> views) {
  double sum = 0, weights = 0;
  bool is_in_an_image = false;
  for (const SeenDepth& view : views) {
    const std::optional<double> behind = BandsBehind(point_in_world, view);
    if (!behind) continue;
    is_in_an_image = true;
    const double weight = std::clamp((1 - *behind) / (1 - kFullWeight), 0.0, 1.0);
    sum += weight * std::max(*behind, -1.0);
    weights += weight;
  }
  if (!is_in_an_image) return -1;
  return weights == 0 ? 1 : sum / weights;
}

LevelSet MarchToOpacity(const TetMesh& mesh, std::span<const SeenDepth> views) {
  std::vector<float> solidity(mesh.positions.size());
  ParallelFor(solidity.size(), kValuesPerTask, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      solidity[v] = float(SolidityAt(glm::dvec3(mesh.positions[v]), views));
    }
  });
  LevelSet set = MarchTetrahedra(mesh, solidity, 0);
  ParallelFor(set.cuts.size(), kValuesPerTask, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      EdgeCut& cut = set.cuts[c];
      const glm::dvec3 solid(mesh.positions[cut.inside]), free(mesh.positions[cut.outside]);
      const double t = CutBetween(solid, double(solidity[cut.inside]), free,
                                  double(solidity[cut.outside]), views);
      cut.t = float(t);
      set.positions[c] = glm::vec3(glm::mix(solid, free, t));
    }
  });
  return set;
}

LevelSet SeenPart(const LevelSet& set, std::span<const SeenDepth> views, double largest_gap) {
  std::vector<uint8_t> is_seen(set.positions.size(), 0);
  ParallelFor(is_seen.size(), kValuesPerTask, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      is_seen[v] = std::any_of(views.begin(), views.end(), [&](const SeenDepth& view) {
        const std::optional<double> behind = BandsBehind(glm::dvec3(set.positions[v]), view);
        return behind && std::abs(*behind) < 1;
      });
    }
  });
  std::vector<uint8_t> marks;
  for (const glm::uvec3& t : set.triangles) {
    marks.push_back(is_seen[t.x] + is_seen[t.y] + is_seen[t.z] >= 2);
  }
  MarkSmallPatches(set, largest_gap, marks);
  return KeepTriangles(set, marks);
}

}  // namespace tetrec
