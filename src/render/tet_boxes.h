// Which tets a ray may meet: a hierarchy of boxes.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

// A binary tree over `order`, each node one box around its stretch of it, a leaf around one tet.
// Nodes lie in preorder: that of [first, last) is followed by its left child's, [first, middle),
// which with all below takes 2 (middle - first) - 1 places. Corners are vertices' coordinates, so
// boxes are exact.
struct TetBoxes {
  struct Box {
    glm::vec3 min, max;
  };
  std::vector<uint32_t> order;  // (T) tets
  std::vector<Box> nodes;       // (2 T - 1)
};

TetBoxes MakeTetBoxes(const TetMesh& mesh);

// A ray ahead of its origin, ready for the boxes.
class BoxRay {
 public:
  BoxRay(const glm::dvec3& origin, const glm::dvec3& direction) : origin_(origin) {
    // No division by 0: 1e-300 times a coordinate still is a number.
    for (int i = 0; i < 3; ++i) inverse_[i] = 1.0 / (direction[i] == 0.0 ? 1e-300 : direction[i]);
  }
  // Differences of floats and doubles are right to one rounding, so distances err by 3 of them: far
  // less than what is allowed for here, and no tet that the ray meets is missed.
  bool MayMeet(const TetBoxes::Box& box) const {
    const glm::dvec3 a = (glm::dvec3(box.min) - origin_) * inverse_,
                     b = (glm::dvec3(box.max) - origin_) * inverse_;
    const glm::dvec3 first = glm::min(a, b), last = glm::max(a, b);
    const double begin = glm::max(glm::max(first.x, first.y), first.z),
                 end = glm::min(glm::min(last.x, last.y), last.z);
    const double slack = 1e-9 * (glm::abs(begin) + glm::abs(end));
    return end + slack >= 0.0 && begin <= end + slack;
  }

 private:
  glm::dvec3 origin_, inverse_;
};

// Calls body(tet) for every tet whose box the ray meets, in no order that matters.
template <class Body>
void ForEachTetNear(const TetBoxes& boxes, const BoxRay& ray, const Body& body, size_t node,
                    size_t first, size_t last) {
  if (!ray.MayMeet(boxes.nodes[node])) return;
  if (last - first == 1) {
    body(boxes.order[first]);
    return;
  }
  const size_t middle = (first + last) / 2;
  ForEachTetNear(boxes, ray, body, node + 1, first, middle);
  ForEachTetNear(boxes, ray, body, node + 2 * (middle - first), middle, last);
}

template <class Body>
void ForEachTetNear(const TetBoxes& boxes, const BoxRay& ray, const Body& body) {
  if (!boxes.order.empty()) ForEachTetNear(boxes, ray, body, 0, 0, boxes.order.size());
}

}  // namespace tetrec
