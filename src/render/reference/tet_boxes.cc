// Builds the hierarchy of boxes: halves by the tets' middles along the longest side.
#include "render/reference/tet_boxes.h"

#include "geometry/bounds3.h"

#include <algorithm>
#include <numeric>

namespace tetrec {
namespace {

glm::vec3 FourTimesMiddle(const TetMesh& mesh, uint32_t t) {
  const glm::uvec4& tet = mesh.tets[t];
  return mesh.positions[tet[0]] + mesh.positions[tet[1]] + mesh.positions[tet[2]] +
         mesh.positions[tet[3]];
}

TetBoxes::Box BoxOf(const TetMesh& mesh, uint32_t t) {
  const glm::uvec4& tet = mesh.tets[t];
  TetBoxes::Box box{mesh.positions[tet[0]], mesh.positions[tet[0]]};
  for (int i = 1; i < 4; ++i) {
    box.min = glm::min(box.min, mesh.positions[tet[i]]);
    box.max = glm::max(box.max, mesh.positions[tet[i]]);
  }
  return box;
}

int LongestSide(const glm::dvec3& size) {
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

void Build(const TetMesh& mesh, TetBoxes& boxes, size_t node, size_t first, size_t last) {
  if (last - first == 1) {
    boxes.nodes[node] = BoxOf(mesh, boxes.order[first]);
    return;
  }
  Bounds3 middles;
  for (size_t i = first; i < last; ++i) {
    middles.Add(glm::dvec3(FourTimesMiddle(mesh, boxes.order[i])));
  }
  const int axis = LongestSide(middles.Size());
  const size_t middle = (first + last) / 2;
  const auto begin = boxes.order.begin();
  std::nth_element(begin + long(first), begin + long(middle), begin + long(last),
                   [&](uint32_t a, uint32_t b) {
                     return FourTimesMiddle(mesh, a)[axis] < FourTimesMiddle(mesh, b)[axis];
                   });
  const size_t left = node + 1, right = node + 2 * (middle - first);
  Build(mesh, boxes, left, first, middle);
  Build(mesh, boxes, right, middle, last);
  boxes.nodes[node] = {glm::min(boxes.nodes[left].min, boxes.nodes[right].min),
                       glm::max(boxes.nodes[left].max, boxes.nodes[right].max)};
}

}  // namespace

TetBoxes MakeTetBoxes(const TetMesh& mesh) {
  TetBoxes boxes;
  boxes.order.resize(mesh.tets.size());
  std::iota(boxes.order.begin(), boxes.order.end(), 0u);
  if (mesh.tets.empty()) return boxes;
  boxes.nodes.resize(2 * mesh.tets.size() - 1);
  Build(mesh, boxes, 0, 0, mesh.tets.size());
  return boxes;
}

}  // namespace tetrec
