// Free and full tets by a minimum cut.
#include "start/free_space.h"

#include "core/error.h"
#include "core/parallel.h"
#include "mesh/locate.h"

#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// Labelling surfaces where no ray decides costs this much per face, so that the cut is small.
constexpr float kFaceCost = 0.05f;
constexpr float kCertain = 1e6f;
// The tet that must be full is this many softnesses behind the point, before the layer of vertices
// behind it: farther away, the cut might as well pass behind the point. Where the walk starts.
constexpr double kBehind = 0.3, kInFront = 0.05;

// What the rays say: capacities of the cut's graph.
struct Votes {
  std::vector<glm::vec4> through;  // (T) from the tet into its neighbour across each face
  std::vector<float> free, full;   // (T) to the two terminals
};

struct Exit {
  int face = -1;
  double at = 0;  // along the ray
};

// The face by which a ray leaves a tet: of those that it meets from inside the nearest.
Exit FindExit(const TetMesh& mesh, uint32_t tet, const glm::dvec3& origin,
              const glm::dvec3& direction) {
  const glm::uvec4& ids = mesh.tets[tet];
  Exit exit{-1, INFINITY};
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 a(mesh.positions[ids[kFaceVertices[i][0]]]);
    const glm::dvec3 b(mesh.positions[ids[kFaceVertices[i][1]]]);
    const glm::dvec3 c(mesh.positions[ids[kFaceVertices[i][2]]]);
    const glm::dvec3 outward = glm::cross(b - a, c - a);
    const double speed = glm::dot(outward, direction);
    if (!(speed > 0)) continue;
    const double at = glm::dot(outward, a - origin) / speed;
    if (at < exit.at) exit = {i, at};
  }
  return exit;
}

// A tet that a ray passes, and the place where it leaves it.
struct Passage {
  uint32_t tet = 0;
  int face = 0;
  double at = 0;  // distance from the point, towards the camera
};

enum class WalkEnd { kCamera, kHull, kLost };

// The tets from the point to the camera.
WalkEnd Walk(const TetMesh& mesh, const SightLine& line, std::vector<Passage>& passages,
             uint32_t& last) {
  passages.clear();
  const double length = glm::distance(line.point, line.camera);
  const glm::dvec3 direction = (line.camera - line.point) / length;
  const glm::dvec3 start = line.point + kInFront * line.softness * direction;
  uint32_t tet = FindTet(mesh, start, line.tet, true);
  while (tet != kNoTet && passages.size() < mesh.tets.size()) {
    last = tet;
    const Exit exit = FindExit(mesh, tet, line.point, direction);
    if (exit.face < 0) return WalkEnd::kLost;
    if (exit.at >= length) return WalkEnd::kCamera;
    passages.push_back({tet, exit.face, exit.at});
    tet = mesh.neighbors[tet][exit.face];
    if (tet == kNoTet) return WalkEnd::kHull;
  }
  return WalkEnd::kLost;
}

// 1 - e^(-d^2 / 2 s^2)
float SoftWeight(double distance, double softness) {
  return float(1 - std::exp(-distance * distance / (2 * softness * softness)));
}

Votes GatherVotes(const TetMesh& mesh, std::span<const SightLine> lines, FreeSpace& result) {
  Votes votes;
  votes.through.assign(mesh.tets.size(), glm::vec4(kFaceCost));
  votes.free.assign(mesh.tets.size(), 0);
  votes.full.assign(mesh.tets.size(), 0);
  std::vector<Passage> passages;
  for (const SightLine& line : lines) {
    uint32_t last = 0;
    const WalkEnd end = Walk(mesh, line, passages, last);
    if (end == WalkEnd::kLost) {
      ++result.lost_lines;
      continue;
    }
    votes.free[last] = kCertain;
    for (const Passage& passage : passages) {
      ++result.crossings[passage.tet];
      const uint32_t towards_camera = mesh.neighbors[passage.tet][passage.face];
      if (towards_camera == kNoTet) continue;
      // The cut pays where the side of the camera is free and that of the point is full.
      const glm::uvec4& back = mesh.neighbors[towards_camera];
      for (int i = 0; i < 4; ++i) {
        if (back[i] == passage.tet) {
          votes.through[towards_camera][i] += SoftWeight(passage.at, line.softness);
        }
      }
    }
    const glm::dvec3 away = glm::normalize(line.point - line.camera);
    const uint32_t behind =
        FindTet(mesh, line.point + kBehind * line.softness * away, line.tet, true);
    if (behind != kNoTet) votes.full[behind] += 1;
  }
  return votes;
}

// The tets' dual graph with two terminals: every edge has its reverse beside it.
using Graph =
    boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                       boost::no_property, uint32_t, uint32_t>;

struct Network {
  std::vector<std::pair<uint32_t, uint32_t>> edges;  // sorted by their first node
  std::vector<float> capacity;
};

// Nodes are the tets, then the free terminal, then the full one.
Network MakeNetwork(const TetMesh& mesh, const Votes& votes) {
  const uint32_t count = uint32_t(mesh.tets.size()), free = count, full = count + 1;
  Network network;
  const auto add = [&](uint32_t from, uint32_t to, float capacity) {
    network.edges.emplace_back(from, to);
    network.capacity.push_back(capacity);
  };
  for (uint32_t t = 0; t < count; ++t) {
    for (int i = 0; i < 4; ++i) {
      if (mesh.neighbors[t][i] != kNoTet) add(t, mesh.neighbors[t][i], votes.through[t][i]);
    }
    add(t, free, 0);
    add(t, full, votes.full[t]);
  }
  for (uint32_t t = 0; t < count; ++t) add(free, t, votes.free[t]);
  for (uint32_t t = 0; t < count; ++t) add(full, t, 0);
  return network;
}

// The index of each edge's reverse: the edges of one node to another are unique.
std::vector<uint32_t> FindReverses(const Network& network, size_t nodes) {
  std::vector<uint32_t> first(nodes + 1, 0);
  for (const auto& [from, to] : network.edges) ++first[from + 1];
  for (size_t i = 1; i <= nodes; ++i) first[i] += first[i - 1];
  const uint32_t tets = uint32_t(nodes - 2);
  std::vector<uint32_t> reverses(network.edges.size());
  for (uint32_t e = 0; e < network.edges.size(); ++e) {
    const auto [from, to] = network.edges[e];
    if (to >= tets) {
      reverses[e] = first[to] + from;  // a terminal's edges are in the order of the tets
      continue;
    }
    uint32_t back = first[to];
    while (network.edges[back].second != from) ++back;
    reverses[e] = back;
  }
  return reverses;
}

}  // namespace

FreeSpace LabelFreeSpace(const TetMesh& mesh, std::span<const SightLine> lines) {
  FreeSpace result;
  result.crossings.assign(mesh.tets.size(), 0);
  const Votes votes = GatherVotes(mesh, lines, result);
  const Network network = MakeNetwork(mesh, votes);
  const size_t nodes = mesh.tets.size() + 2, edges = network.edges.size();
  const std::vector<uint32_t> reverses = FindReverses(network, nodes);
  const Graph graph(boost::edges_are_sorted, network.edges.begin(), network.edges.end(),
                    uint32_t(nodes));

  std::vector<Graph::edge_descriptor> edge_of(edges), reverse(edges), predecessor(nodes);
  const auto index = boost::get(boost::edge_index, graph);
  for (auto [e, end] = boost::edges(graph); e != end; ++e) edge_of[get(index, *e)] = *e;
  for (size_t e = 0; e < edges; ++e) reverse[e] = edge_of[reverses[e]];
  std::vector<float> residual(edges);
  std::vector<boost::default_color_type> color(nodes);
  std::vector<long> distance(nodes);
  const auto of_vertex = boost::get(boost::vertex_index, graph);
  const auto by_edge = [&](auto& values) {
    return boost::make_iterator_property_map(values.begin(), index);
  };
  const auto by_vertex = [&](auto& values) {
    return boost::make_iterator_property_map(values.begin(), of_vertex);
  };
  boost::boykov_kolmogorov_max_flow(
      graph, by_edge(network.capacity), by_edge(residual), by_edge(reverse), by_vertex(predecessor),
      by_vertex(color), by_vertex(distance), of_vertex, uint32_t(nodes - 2), uint32_t(nodes - 1));
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    result.is_full.push_back(color[t] == boost::black_color ? 0 : 1);
  }
  return result;
}

}  // namespace tetrec
