// A mesh loses the vertices that it can do without, by collapse of edges.
#include "refine/collapse.h"

#include "core/parallel.h"
#include "mesh/tet_quality.h"
#include "refine/vertex_values.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace tetrec {
namespace {

// A tet may become as bad as the worst one around the vertex, or as bad as this
// (ParthasarathyQuality).
constexpr double kLeastQuality = 0.02;
// A place is darkened if the opacity over the mean edge of its tet rises by this. It is stricter
// than after a new triangulation (darkened.cc), because it costs nothing to leave a vertex.
constexpr double kMostDarkening = 0.05;
// Among collapses that change the pictures equally little, the one with better tets wins.
constexpr double kWeightOfQuality = 1e-6;
// Estimates of errors are needed for those neighbours only that promise the least.
constexpr size_t kComparedNeighbors = 3;

constexpr uint32_t kNoVertex = 0xFFFFFFFFu;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The tets around a vertex as they are, or as they would be after a collapse.
using StarTets = std::vector<glm::uvec4>;

// Barycentric weights of a point; NaN in a tet whose volume is 0 in double.
glm::dvec4 WeightsOf(const TetCorners& corners, const glm::dvec3& point) {
  glm::dvec4 weights;
  for (size_t i = 0; i < 4; ++i) {
    TetCorners moved = corners;
    moved[i] = point;
    weights[int(i)] = SignedVolume(moved);
  }
  return weights / SignedVolume(corners);
}

class Collapsing {
 public:
  Collapsing(EditedMesh& mesh, std::vector<uint8_t> stays, std::vector<glm::dvec4> values,
             const std::vector<float>& light)
      : mesh_(mesh),
        stays_(std::move(stays)),
        values_(std::move(values)),
        light_(light.begin(), light.end()),
        choices_(mesh.vertices()),
        inherited_(mesh.vertices(), 0.0),
        darkening_(mesh.vertices(), 0.0),
        is_stale_(mesh.vertices(), 1),
        is_queued_(mesh.vertices(), 0) {}

  Collapsed Run(double most_error) {
    ParallelFor(mesh_.vertices(), 1024, [&](size_t begin, size_t end) {
      for (uint32_t v = uint32_t(begin); v < end; ++v) {
        if (!stays_[v]) choices_[v] = BestChoice(v, false);
      }
    });
    for (uint32_t v = 0; v < mesh_.vertices(); ++v) {
      if (choices_[v].onto != kNoVertex) Enqueue(v, choices_[v].error);
    }
    Collapsed collapsed;
    double error = 0;
    while (!queue_.empty()) {
      const auto [cost, v] = queue_.top();
      queue_.pop();
      is_queued_[v] = 0;
      if (is_stale_[v]) {
        is_stale_[v] = 0;
        choices_[v] = BestChoice(v, true);
        if (choices_[v].onto != kNoVertex) Enqueue(v, choices_[v].error + inherited_[v]);
        continue;
      }
      if (error + cost > most_error) break;
      error += cost;
      ++(LightAround(v) > 0 ? collapsed.flat : collapsed.empty);
      Collapse(v, cost);
    }
    return collapsed;
  }

 private:
  struct Choice {
    uint32_t onto = kNoVertex;
    double error = kInfinity;  // by which the pictures' squared error would grow
    double darkening = 0;      // largest rise of the opacity of a place
  };

  double LightAround(uint32_t v) const {
    double sum = 0;
    for (const uint32_t t : mesh_.TetsAt(v)) sum += light_[t];
    return sum;
  }

  std::vector<uint32_t> NeighborsOf(uint32_t v) const {
    std::vector<uint32_t> neighbors;
    for (const uint32_t t : mesh_.TetsAt(v)) {
      for (int i = 0; i < 4; ++i) {
        if (mesh_.tet(t)[i] != v) neighbors.push_back(mesh_.tet(t)[i]);
      }
    }
    std::ranges::sort(neighbors);
    neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
    return neighbors;
  }

  StarTets StarAfter(uint32_t v, uint32_t onto) const {
    StarTets star;
    for (const uint32_t t : mesh_.TetsAt(v)) {
      if (!Contains(mesh_.tet(t), onto)) {
        star.push_back(WithVertexReplaced(mesh_.tet(t), v, onto));
      }
    }
    return star;
  }

  double WorstQuality(uint32_t v) const {
    double worst = 1;
    for (const uint32_t t : mesh_.TetsAt(v)) {
      worst = std::min(worst, ParthasarathyQuality(CornersOf(mesh_.positions(), mesh_.tet(t))));
    }
    return worst;
  }

  // The worst quality of a star, or none if that is below `least` or a tet is not positively
  // oriented.
  std::optional<double> QualityOf(const StarTets& star, double least) const {
    double worst = 1;
    for (const glm::uvec4& tet : star) {
      worst = std::min(worst, ParthasarathyQuality(CornersOf(mesh_.positions(), tet)));
      if (worst < least) return {};
    }
    for (const glm::uvec4& tet : star) {
      if (!IsPositive(mesh_.position(tet[0]), mesh_.position(tet[1]), mesh_.position(tet[2]),
                      mesh_.position(tet[3]))) {
        return {};
      }
    }
    return worst;
  }

  // The values that a star shows at a point, in the tet that contains it.
  glm::dvec4 ValueAt(const StarTets& star, const glm::dvec3& point) const {
    double best = -kInfinity;
    glm::dvec4 value(0.0);
    for (const glm::uvec4& tet : star) {
      glm::dvec4 weights = WeightsOf(CornersOf(mesh_.positions(), tet), point);
      const double least = std::min({weights[0], weights[1], weights[2], weights[3]});
      if (!std::isfinite(least) || !(least > best)) continue;
      best = least;
      weights = glm::max(weights, 0.0);  // by rounding, the point may be just outside of all
      weights /= weights[0] + weights[1] + weights[2] + weights[3];
      value = glm::dvec4(0.0);
      for (int i = 0; i < 4; ++i) value += weights[i] * values_[tet[i]];
      if (least >= 0) break;
    }
    return value;
  }

  double MeanDistance(uint32_t v, const std::vector<uint32_t>& others) const {
    double sum = 0;
    for (const uint32_t other : others) {
      sum += double(glm::distance(mesh_.position(v), mesh_.position(other)));
    }
    return sum / double(others.size());
  }

  // The neighbours that leave sound tets, those first that change the values at the vertex least.
  std::vector<uint32_t> RankedNeighbors(uint32_t v) const {
    const std::vector<uint32_t> neighbors = NeighborsOf(v);
    const double length = MeanDistance(v, neighbors);
    const double least_quality = std::min(kLeastQuality, WorstQuality(v));
    std::vector<std::pair<double, uint32_t>> ranked;
    for (const uint32_t onto : neighbors) {
      const StarTets star = StarAfter(v, onto);
      const std::optional<double> quality = QualityOf(star, least_quality);
      if (!quality) continue;
      const glm::dvec4 value = ValueAt(star, glm::dvec3(mesh_.position(v)));
      const double change = SquaredChange(value, values_[v], length);
      if (!std::isfinite(change)) continue;
      ranked.emplace_back(change + kWeightOfQuality * (1 - *quality), onto);
    }
    std::ranges::sort(ranked);
    std::vector<uint32_t> result;
    for (const auto& [rank, onto] : ranked) result.push_back(onto);
    return result;
  }

  // `stays_clear`: without those that darken a place, which takes longer.
  Choice BestChoice(uint32_t v, bool stays_clear) const {
    Choice best;
    size_t compared = 0;
    for (const uint32_t onto : RankedNeighbors(v)) {
      const StarTets after = StarAfter(v, onto);
      const double darkening = stays_clear ? DarkeningBy(v, after) : 0.0;
      if (darkening_[v] + darkening > kMostDarkening) continue;
      const double error = ErrorOf(v, after);
      if (error < best.error) best = {onto, error, darkening};
      if (++compared == kComparedNeighbors) break;
    }
    return best;
  }

  // By how much the squared error would grow, from the light that rays lose in each tet around a
  // vertex and from what the tet's centroid shows then.
  double ErrorOf(uint32_t v, const StarTets& after) const {
    double error = 0;
    for (const uint32_t t : mesh_.TetsAt(v)) {
      if (!(light_[t] > 0)) continue;
      const TetCorners p = CornersOf(mesh_.positions(), mesh_.tet(t));
      const glm::dvec4 now = ValueAt(after, MiddleOf(p));
      error += light_[t] * SquaredChange(now, MeanValue(mesh_.tet(t)), MeanEdge(p));
    }
    return error;
  }

  // The largest rise of the opacity at the vertex and at the centroids of the tets around it, those
  // that go and those that replace them: each may miss what the others show.
  double DarkeningBy(uint32_t v, const StarTets& after) const {
    StarTets before;
    for (const uint32_t t : mesh_.TetsAt(v)) before.push_back(mesh_.tet(t));
    double most = 0;
    const auto compare = [&](double length, double was, double is) {
      most = std::max(most, Opacity(is, length) - Opacity(was, length));
    };
    double longest = 0;
    for (const glm::uvec4& tet : before) {
      const TetCorners p = CornersOf(mesh_.positions(), tet);
      longest = std::max(longest, MeanEdge(p));
      compare(MeanEdge(p), MeanValue(tet).a, ValueAt(after, MiddleOf(p)).a);
    }
    for (const glm::uvec4& tet : after) {
      const TetCorners p = CornersOf(mesh_.positions(), tet);
      compare(MeanEdge(p), ValueAt(before, MiddleOf(p)).a, MeanValue(tet).a);
    }
    const glm::dvec3 place(mesh_.position(v));
    compare(longest, values_[v].a, ValueAt(after, place).a);
    return most;
  }

  static glm::dvec3 MiddleOf(const TetCorners& p) { return 0.25 * (p[0] + p[1] + p[2] + p[3]); }
  glm::dvec4 MeanValue(const glm::uvec4& tet) const {
    return 0.25 * (values_[tet[0]] + values_[tet[1]] + values_[tet[2]] + values_[tet[3]]);
  }

  void Enqueue(uint32_t v, double cost) {
    queue_.emplace(cost, v);
    is_queued_[v] = 1;
  }

  // The light of tets that vanish goes to those that take their place.
  void Collapse(uint32_t v, double cost) {
    const uint32_t onto = choices_[v].onto;
    const double darkening = darkening_[v] + choices_[v].darkening;
    const std::vector<uint32_t> neighbors = NeighborsOf(v);
    double vanished = 0;
    std::vector<uint32_t> left;
    for (const uint32_t t : mesh_.TetsAt(v)) {
      if (Contains(mesh_.tet(t), onto)) {
        vanished += light_[t];
      } else {
        left.push_back(t);
      }
    }
    mesh_.Collapse(v, onto);
    for (const uint32_t t : left) light_[t] += vanished / double(left.size());
    for (const uint32_t neighbor : neighbors) {
      if (stays_[neighbor]) continue;
      inherited_[neighbor] += cost;
      darkening_[neighbor] = std::max(darkening_[neighbor], darkening);
      is_stale_[neighbor] = 1;
      if (!is_queued_[neighbor]) Enqueue(neighbor, inherited_[neighbor]);
    }
  }

  using Candidate = std::pair<double, uint32_t>;  // estimated error, vertex

  EditedMesh& mesh_;
  std::vector<uint8_t> stays_;
  std::vector<glm::dvec4> values_;
  std::vector<double> light_;       // (T)
  std::vector<Choice> choices_;     // (V)
  std::vector<double> inherited_;   // (V) estimates taken over from removed neighbours
  std::vector<double> darkening_;   // (V) by collapses around it
  std::vector<uint8_t> is_stale_;   // (V) not looked at closely since the tets around it changed
  std::vector<uint8_t> is_queued_;  // (V)
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
};

}  // namespace

Collapsed CollapseSpare(EditedMesh& mesh, std::vector<uint8_t> stays, const FieldState& state,
                        const RefineScores& scores, const RefineOptions& options) {
  Collapsing collapsing(mesh, std::move(stays), ValuesAtVertices(state), scores.visible_of_tets);
  return collapsing.Run(options.flat_error * scores.squared_error);
}

}  // namespace tetrec
