// A hierarchy of boxes that finds the tets that a ray may meet.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace tetrec {

// A binary tree over `order`, each node one box around its stretch of it, a leaf around one tet.
// Nodes are in preorder: that of [first, last) is followed by its left child's, [first, middle),
// which takes 2 (middle - first) - 1 places with its descendants. Corners are coordinates of
// vertices, so boxes are exact.
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
  BoxRay(const glm::dvec3& origin, const glm::dvec3& direction)
      : origin_(origin), direction_(direction), inverse_(1.0 / direction) {}
  // Differences of floats and doubles are right to one rounding, so distances are right to 3 of
  // them: far less than the margin here, and no tet that the ray meets is missed.
  bool MayMeet(const TetBoxes::Box& box) const {
    double begin = 0.0, end = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
      const double to_min = double(box.min[i]) - origin_[i],
                   to_max = double(box.max[i]) - origin_[i];
      if (direction_[i] == 0.0) {
        if (to_min > 0.0 || to_max < 0.0) return false;
        continue;
      }
      const double a = to_min * inverse_[i], b = to_max * inverse_[i];
      begin = std::max(begin, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    return begin * (1.0 - kSlack) <= end * (1.0 + kSlack);
  }

 private:
  static constexpr double kSlack = 1e-12;
  glm::dvec3 origin_, direction_, inverse_;
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
