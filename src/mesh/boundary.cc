// The boundary of a mesh: its faces and vertices, a check for convexity, a tree of boxes over them.
#include "mesh/boundary.h"

#include "core/error.h"
#include "geometry/bounds3.h"
#include "geometry/orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>

namespace tetrec {
namespace {

// Counter-clockwise seen from outside.
std::array<uint32_t, 3> VerticesOf(const TetMesh& mesh, const BoundaryFace& face) {
  std::array<uint32_t, 3> ids;
  for (int i = 0; i < 3; ++i) ids[i] = mesh.tets[face.tet][kFaceVertices[face.face][i]];
  return ids;
}

// Positive if `point` is outside the plane of the face.
int SideOf(const TetMesh& mesh, const std::array<uint32_t, 3>& face, uint32_t point) {
  return Orientation(mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]],
                     mesh.positions[point]);
}

// The vertices with the smallest and the largest x, y and z.
std::array<uint32_t, 6> ExtremeVertices(const TetMesh& mesh) {
  std::array<uint32_t, 6> extremes{};
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const float x = mesh.positions[v][axis];
      if (x < mesh.positions[extremes[2 * axis]][axis]) extremes[2 * axis] = v;
      if (x > mesh.positions[extremes[2 * axis + 1]][axis]) extremes[2 * axis + 1] = v;
    }
  }
  return extremes;
}

uint64_t CountReachable(const TetMesh& mesh) {
  std::vector<uint8_t> seen(mesh.tets.size(), 0);
  std::vector<uint32_t> stack{0};
  seen[0] = 1;
  uint64_t reached = 0;
  while (!stack.empty()) {
    const uint32_t t = stack.back();
    stack.pop_back();
    ++reached;
    for (int i = 0; i < 4; ++i) {
      const uint32_t neighbor = mesh.neighbors[t][i];
      if (neighbor == kNoTet || seen[neighbor]) continue;
      seen[neighbor] = 1;
      stack.push_back(neighbor);
    }
  }
  return reached;
}

struct HalfEdge {
  uint32_t from, to;  // as wound in its face
  uint32_t far;       // the face's third vertex
  uint64_t Key() const { return uint64_t(std::min(from, to)) << 32 | std::max(from, to); }
};

// Two faces must meet at every edge, and the far vertex of neither may be outside the plane of the
// other. A closed, connected surface that is convex along every edge bounds a convex solid.
std::string FirstEdgeNotConvex(const TetMesh& mesh, std::span<const BoundaryFace> faces) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * faces.size());
  for (const BoundaryFace& face : faces) {
    const std::array<uint32_t, 3> v = VerticesOf(mesh, face);
    for (int k = 0; k < 3; ++k) edges.push_back({v[k], v[(k + 1) % 3], v[(k + 2) % 3]});
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.Key() != b.Key() ? a.Key() < b.Key() : a.far < b.far;
  });
  for (size_t e = 0; e < edges.size(); e += 2) {
    const HalfEdge& a = edges[e];
    const bool is_pair = e + 1 < edges.size() && a.Key() == edges[e + 1].Key() &&
                         a.from == edges[e + 1].to &&
                         (e + 2 == edges.size() || edges[e + 2].Key() != a.Key());
    if (!is_pair) {
      return fmt::format("the boundary is not a closed surface at edge {}-{}", a.from, a.to);
    }
    if (SideOf(mesh, {a.from, a.to, a.far}, edges[e + 1].far) > 0) {
      return fmt::format("the boundary is not convex at edge {}-{}", a.from, a.to);
    }
  }
  return "";
}

struct Split {
  glm::vec3 middle;
  BoundaryFace face;
};

class TreeBuilder {
 public:
  TreeBuilder(const TetMesh& mesh, std::span<const BoundaryFace> faces, BoxTree& tree)
      : mesh_(mesh), tree_(tree) {
    const Bounds3 bounds = BoundsOf(mesh.positions);
    // The error of a kernel's coordinates is at most 2^-21 of these lengths.
    margin_ = float(4e-6 * (glm::length(bounds.Center()) + bounds.Diagonal()));
    splits_.reserve(faces.size());
    for (const BoundaryFace& face : faces) splits_.push_back({Middle(face), face});
  }

  void Build(uint32_t node, size_t begin, size_t end) {
    if (node >= tree_.leaves) {
      MakeLeaf(node, begin, end);
      return;
    }
    const uint32_t axis = LongestAxis(begin, end);
    const size_t middle = begin + (end - begin) / 2;
    std::nth_element(
        splits_.begin() + begin, splits_.begin() + middle, splits_.begin() + end,
        [axis](const Split& a, const Split& b) { return a.middle[axis] < b.middle[axis]; });
    Build(2 * node, begin, middle);
    Build(2 * node + 1, middle, end);
    const BoxNode &a = tree_.nodes[2 * node], &b = tree_.nodes[2 * node + 1];
    tree_.nodes[node] = {glm::min(a.min, b.min), axis, glm::max(a.max, b.max), 0};
  }

  const std::vector<Split>& splits() const { return splits_; }

 private:
  glm::vec3 Middle(const BoundaryFace& face) const {
    glm::vec3 middle(0.0f);
    for (uint32_t v : VerticesOf(mesh_, face)) middle += mesh_.positions[v] / 3.0f;
    return middle;
  }

  uint32_t LongestAxis(size_t begin, size_t end) const {
    glm::vec3 low = splits_[begin].middle, high = low;
    for (size_t i = begin; i < end; ++i) {
      low = glm::min(low, splits_[i].middle);
      high = glm::max(high, splits_[i].middle);
    }
    const glm::vec3 size = high - low;
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  }

  void MakeLeaf(uint32_t node, size_t begin, size_t end) {
    BoxNode leaf{mesh_.positions[VerticesOf(mesh_, splits_[begin].face)[0]], uint32_t(begin)};
    leaf.max = leaf.min;
    leaf.second = uint32_t(end - 1);
    for (size_t i = begin; i < end; ++i) {
      for (uint32_t v : VerticesOf(mesh_, splits_[i].face)) {
        leaf.min = glm::min(leaf.min, mesh_.positions[v]);
        leaf.max = glm::max(leaf.max, mesh_.positions[v]);
      }
    }
    leaf.min -= margin_;
    leaf.max += margin_;
    tree_.nodes[node] = leaf;
  }

  const TetMesh& mesh_;
  BoxTree& tree_;
  float margin_ = 0;
  std::vector<Split> splits_;
};

}  // namespace

std::vector<BoundaryFace> BoundaryFaces(const TetMesh& mesh) {
  std::vector<BoundaryFace> faces;
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (uint32_t face = 0; face < 4; ++face) {
      if (mesh.neighbors[t][face] == kNoTet) faces.push_back({t, face});
    }
  }
  return faces;
}

std::vector<uint8_t> BoundaryVertices(const TetMesh& mesh) {
  std::vector<uint8_t> on_boundary(mesh.positions.size(), 0);
  for (const BoundaryFace& face : BoundaryFaces(mesh)) {
    for (uint32_t v : VerticesOf(mesh, face)) on_boundary[v] = 1;
  }
  return on_boundary;
}

std::string WhyNotConvex(const TetMesh& mesh, std::span<const BoundaryFace> faces) {
  // A cheap test first: faces around a hole usually have an outermost vertex of the mesh in front.
  const std::array<uint32_t, 6> extremes = ExtremeVertices(mesh);
  for (const BoundaryFace& face : faces) {
    const std::array<uint32_t, 3> v = VerticesOf(mesh, face);
    for (uint32_t extreme : extremes) {
      if (SideOf(mesh, v, extreme) > 0) {
        return fmt::format("the boundary is not convex: vertex {} is in front of face {}-{}-{}",
                           extreme, v[0], v[1], v[2]);
      }
    }
  }
  const uint64_t reached = CountReachable(mesh);
  if (reached != mesh.tets.size()) {
    return fmt::format("the mesh is not connected: {} of {} tets are reached from tet 0", reached,
                       mesh.tets.size());
  }
  return FirstEdgeNotConvex(mesh, faces);
}

BoxTree BuildBoxTree(const TetMesh& mesh, std::vector<BoundaryFace>& faces) {
  TETREC_CHECK(!faces.empty(), "a boundary without faces");
  BoxTree tree;
  tree.leaves = std::bit_floor(uint32_t(faces.size()));  // one or two faces per leaf
  tree.nodes.resize(2 * size_t(tree.leaves));
  TreeBuilder builder(mesh, faces, tree);
  builder.Build(1, 0, faces.size());
  for (size_t i = 0; i < faces.size(); ++i) faces[i] = builder.splits()[i].face;
  return tree;
}

}  // namespace tetrec
