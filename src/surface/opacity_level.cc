// The surface where cameras see it.
#include "surface/opacity_level.h"

#include "core/disjoint_sets.h"
#include "core/parallel.h"
#include "geometry/bounds3.h"
#include "surface/depth_between.h"
#include "surface/edge_distances.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

// A cut is found when it is known to a share of its edge, or when the solidity there is below a
// hundredth of a band, or after some steps, which a jump of the solidity may need.
constexpr double kFinest = 1.0 / 256, kExact = 0.01;
constexpr int kMostSteps = 8;

// A camera sees a surface from 12 degrees above it on: the least cosine between the surface's
// normal and the direction to the camera. Normals are those of SmoothNormals after some rounds,
// because triangles of marching tetrahedra are turned at random.
constexpr double kLeastFacing = 0.2;
constexpr int kRoundsOfNormals = 2;

// A surface faces enough cameras if it faces one of ten, three at most. One camera's rays may end
// anywhere as far as other cameras know: such surfaces hung in rags from the rim of a table.
constexpr size_t kViewsPerWitness = 10, kMostWitnesses = 3;

// A patch that faces too few cameras stays if less than this share of its area is hidden: then it
// is the flat side of something, not the edge of what no camera sees.
constexpr double kHiddenShare = 0.1;

// Strips at a border that are narrower than this share of the largest gap are rags.
constexpr float kRagWidth = 0.2f;

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
  if (const auto depth = DepthBetween(depths, {right, down}, jump)) return *depth;
  const double nearest = depths[size_t(2 * int(down > 0.5) + int(right > 0.5))];
  return nearest == kNoDepth ? std::numeric_limits<double>::infinity() : nearest;
}

// The depth up to which the ray through a pixel is free, if nothing is known about it beyond.
std::optional<double> FreeUntil(const SeenDepth& view, const glm::dvec2& pixel) {
  const DepthMap& map = view.free_until;
  if (map.depth.empty()) return std::nullopt;
  const float depth = map.At(std::clamp(int(pixel.x), 0, map.width - 1),
                             std::clamp(int(pixel.y), 0, map.height - 1));
  return depth == kNoDepth ? std::nullopt : std::optional(double(depth));
}

// How far a point is behind where the ray through it is stopped, in bands. Nothing if it is outside
// of the image, or where nothing is known about the ray.
std::optional<double> BandsBehind(const glm::dvec3& point_in_world, const SeenDepth& view) {
  const glm::dvec3 in_cam = view.cam_from_world * point_in_world;
  if (!view.camera.Shows(in_cam)) return std::nullopt;
  const glm::dvec2 pixel = view.camera.ImageFromCam(in_cam);
  if (const std::optional<double> free = FreeUntil(view, pixel)) {
    return in_cam.z < *free ? std::optional(-std::numeric_limits<double>::infinity())
                            : std::nullopt;
  }
  const double footprint = in_cam.z / view.camera.fx;
  const double depth = DepthAt(view, pixel, kJumpOfDepths_px * footprint);
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
    if (std::abs(solidity) < kExact) return std::clamp(share, kLeastCutShare, 1 - kLeastCutShare);
    if (sign == last_sign) (sign > 0 ? high : low).solidity *= 0.5;
    last_sign = sign;
  }
  return std::clamp(share_at_zero(), kLeastCutShare, 1 - kLeastCutShare);
}

// How cameras see a place on a surface.
enum class Sight : uint8_t {
  kHidden,   // no camera's rays end near it
  kGlanced,  // the rays of some cameras do, but the surface faces too few of these
  kFaced     // the surface faces enough of these
};

Sight SightOf(const glm::dvec3& point_in_world, const glm::dvec3& normal,
              std::span<const SeenDepth> views) {
  const size_t needed = std::clamp<size_t>(views.size() / kViewsPerWitness, 1, kMostWitnesses);
  size_t faced = 0;
  Sight sight = Sight::kHidden;
  for (const SeenDepth& view : views) {
    const std::optional<double> behind = BandsBehind(point_in_world, view);
    if (!behind || std::abs(*behind) >= 1) continue;
    sight = Sight::kGlanced;
    const glm::dvec3 towards = view.cam_from_world.Inverse().translation - point_in_world;
    faced += glm::dot(normal, towards) > kLeastFacing * glm::length(towards);
    if (faced >= needed) return Sight::kFaced;
  }
  return sight;
}

// The sight of each triangle: the second best of its corners.
std::vector<Sight> SightsOf(const TriangleMesh& mesh, std::span<const SeenDepth> views) {
  const std::vector<glm::dvec3> normals = SmoothNormals(mesh, kRoundsOfNormals);
  std::vector<Sight> of_vertices(mesh.positions.size());
  ParallelFor(of_vertices.size(), kValuesPerTask, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      of_vertices[v] = SightOf(glm::dvec3(mesh.positions[v]), normals[v], views);
    }
  });
  std::vector<Sight> sights;
  for (const glm::uvec3& t : mesh.triangles) {
    std::array<Sight, 3> corners = {of_vertices[t.x], of_vertices[t.y], of_vertices[t.z]};
    std::ranges::sort(corners);
    sights.push_back(corners[1]);
  }
  return sights;
}

// A connected patch of triangles that face too few cameras.
struct Patch {
  Bounds3 box;
  double area = 0, hidden_area = 0;

  bool Stays(double largest_gap) const {
    return box.Diagonal() <= largest_gap || hidden_area < kHiddenShare * area;
  }
};

// For each vertex of such a triangle the smallest id of a vertex of its patch.
std::vector<uint32_t> FindPatches(const LevelSet& set, std::span<const Sight> sights) {
  DisjointSets patches(set.positions.size());
  for (size_t f = 0; f < sights.size(); ++f) {
    if (sights[f] == Sight::kFaced) continue;
    patches.Join(set.triangles[f].x, set.triangles[f].y);
    patches.Join(set.triangles[f].x, set.triangles[f].z);
  }
  std::vector<uint32_t> roots(set.positions.size());
  for (uint32_t v = 0; v < roots.size(); ++v) roots[v] = patches.Root(v);
  return roots;
}

// For each vertex, whether it belongs to a triangle whose mark is `mark`.
std::vector<uint8_t> VerticesOf(const LevelSet& set, std::span<const uint8_t> marks, uint8_t mark) {
  std::vector<uint8_t> vertices(set.positions.size(), 0);
  for (size_t f = 0; f < marks.size(); ++f) {
    if (marks[f] != mark) continue;
    for (int k = 0; k < 3; ++k) vertices[set.triangles[f][k]] = 1;
  }
  return vertices;
}

// How far a triangle's vertices are from some triangles, along edges; infinite beyond a radius.
struct Reach {
  float nearest, farthest;
};

// From the triangles whose marks are `mark`.
std::vector<Reach> ReachesOf(const LevelSet& set, std::span<const uint8_t> marks, uint8_t mark,
                             float radius) {
  const std::vector<float> distances =
      EdgeDistances(set.positions, set.triangles, VerticesOf(set, marks, mark), radius);
  std::vector<Reach> reaches;
  for (const glm::uvec3& t : set.triangles) {
    const auto [nearest, farthest] = std::minmax({distances[t.x], distances[t.y], distances[t.z]});
    reaches.push_back({nearest, farthest});
  }
  return reaches;
}

// Marks the triangles in gaps of up to twice the radius between marked ones: a closing, as of
// binary images (Serra, Image Analysis and Mathematical Morphology, 1982), along the surface.
void CloseGaps(const LevelSet& set, float radius, std::vector<uint8_t>& marks) {
  std::vector<uint8_t> dilated;
  for (const Reach& reach : ReachesOf(set, marks, 1, radius)) {
    dilated.push_back(reach.farthest <= radius);
  }
  const std::vector<Reach> from_far = ReachesOf(set, dilated, 0, radius);
  for (size_t f = 0; f < marks.size(); ++f) {
    if (from_far[f].nearest > radius) marks[f] = 1;
  }
}

// Unmarks the triangles of strips narrower than twice the radius, or than two triangles: an
// opening, along the surface.
void DropRags(const LevelSet& set, float radius, std::vector<uint8_t>& marks) {
  const std::vector<float> from_unmarked =
      EdgeDistances(set.positions, set.triangles, VerticesOf(set, marks, 0), radius);
  std::vector<uint8_t> is_core;
  for (const float distance : from_unmarked) is_core.push_back(distance > radius);
  const std::vector<float> from_core = EdgeDistances(set.positions, set.triangles, is_core, radius);
  for (size_t f = 0; f < marks.size(); ++f) {
    const glm::uvec3& t = set.triangles[f];
    if (std::min({from_core[t.x], from_core[t.y], from_core[t.z]}) > radius) marks[f] = 0;
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
  const TriangleMesh mesh{.positions = set.positions, .triangles = set.triangles};
  const std::vector<Sight> sights = SightsOf(mesh, views);
  const std::vector<uint32_t> patch_of_vertex = FindPatches(set, sights);
  std::vector<Patch> patches(set.positions.size());
  for (size_t f = 0; f < sights.size(); ++f) {
    if (sights[f] == Sight::kFaced) continue;
    const glm::uvec3& t = set.triangles[f];
    const double area = 0.5 * glm::length(DoubleAreaNormal(mesh, t));
    Patch& patch = patches[patch_of_vertex[t.x]];
    for (int k = 0; k < 3; ++k) patch.box.Add(glm::dvec3(set.positions[t[k]]));
    patch.area += area;
    if (sights[f] == Sight::kHidden) patch.hidden_area += area;
  }
  std::vector<uint8_t> marks;
  for (size_t f = 0; f < sights.size(); ++f) {
    const Patch& patch = patches[patch_of_vertex[set.triangles[f].x]];
    marks.push_back(sights[f] == Sight::kFaced || patch.Stays(largest_gap));
  }
  CloseGaps(set, 0.5f * float(largest_gap), marks);
  DropRags(set, 0.5f * kRagWidth * float(largest_gap), marks);
  return KeepTriangles(set, marks);
}

}  // namespace tetrec
