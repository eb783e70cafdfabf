#include "surface/edge_distances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tetrec {
namespace {

// Two triangles side by side, and one apart from them.
TEST(EdgeDistances, FollowEdgesUpToAnEnd) {
  const std::vector<glm::vec3> positions = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {6, 4, 0},
                                            {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<glm::uvec3> triangles = {{0, 1, 2}, {2, 1, 3}, {4, 5, 6}};
  const std::vector<uint8_t> is_source = {1, 0, 0, 0, 0, 0, 0};
  constexpr float kNone = std::numeric_limits<float>::infinity();
  EXPECT_EQ(EdgeDistances(positions, triangles, is_source, 100),
            (std::vector<float>{0, 3, 5, 8, kNone, kNone, kNone}));
  EXPECT_EQ(EdgeDistances(positions, triangles, is_source, 5),
            (std::vector<float>{0, 3, 5, kNone, kNone, kNone, kNone}));
  const std::vector<uint8_t> none(positions.size(), 0);
  EXPECT_EQ(EdgeDistances(positions, triangles, none, 100), std::vector<float>(7, kNone));
}

}  // namespace
}  // namespace tetrec
