#include "render/seen_colors.h"

#include "field/extra_attribute.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(PlacesOfRows, AreVerticesOrCentroids) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
  mesh.tets = {{0, 1, 2, 3}};
  EXPECT_EQ(PlacesOfRows(mesh, FieldStorage::kVertex), mesh.positions);
  EXPECT_EQ(PlacesOfRows(mesh, FieldStorage::kCell), std::vector<glm::vec3>{glm::vec3(1.0f)});
}

// Rows of 4 + 9 + 5 parameters, 4 first moments and 4 + 1 + 1 second ones.
TEST(WithHarmonics, KeepsWhatBothDegreesHave) {
  FieldLayout layout;
  layout.attributes.push_back(HarmonicsAttribute(1));
  FieldState state = WithoutMoments(WithExtra(layout), std::vector<float>(2 * 18));
  float next = 1;
  for (auto* values : {&state.parameters, &state.first_moment, &state.second_moment}) {
    for (float& value : *values) value = next++;
  }
  const FieldState none = WithHarmonics(state, 0), two = WithHarmonics(state, 2);
  EXPECT_EQ(none.first_moment, state.first_moment);
  EXPECT_EQ(two.first_moment, state.first_moment);
  const std::vector<float>& before = state.second_moment;
  EXPECT_EQ(two.second_moment, before);
  EXPECT_EQ(none.second_moment,
            (std::vector<float>{before[0], before[1], before[2], before[3], before[5], before[6],
                                before[7], before[8], before[9], before[11]}));
  ASSERT_EQ(two.parameters.size(), 2u * (4 + 24 + 5));
  for (size_t row = 0; row < 2; ++row) {
    const float* from = &state.parameters[row * 18];
    const float* to = &two.parameters[row * 33];
    for (size_t c = 0; c < 13; ++c) EXPECT_EQ(to[c], from[c]);
    for (size_t c = 13; c < 28; ++c) EXPECT_EQ(to[c], 0.0f) << "new";
    for (size_t c = 0; c < 5; ++c) EXPECT_EQ(to[28 + c], from[13 + c]) << "the extra attribute";
  }
  // A degree that comes back begins with its moments at 0.
  const FieldState again = WithHarmonics(none, 1);
  EXPECT_EQ(again.second_moment[4], 0.0f);
  EXPECT_EQ(again.second_moment[5], before[5]);
}

}  // namespace
}  // namespace tetrec
