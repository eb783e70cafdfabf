// Fields as an optimiser sees them, and their prolongation.
#include "field/field_state.h"

#include "field/extra_attribute.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

RadianceField OneTetWithExtraValues() {
  RadianceField field;
  field.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  field.density = {0, 1, 2, 3.5f};
  field.color_srgb = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1f, 0.5f, 0.9f}};
  field.others = {{kExtraAttribute, {}}};
  for (int i = 0; i < 20; ++i) field.others[0].values.push_back(float(i) - 7.5f);
  return field;
}

TEST(FieldState, HasTheParametersOfAFieldRowByRow) {
  const RadianceField field = OneTetWithExtraValues();
  const FieldState state = StateOf(field);
  ASSERT_EQ(state.layout, WithExtra({}));
  ASSERT_EQ(state.rows(), 4u);
  EXPECT_EQ(state.parameters[3 * 9 + kColorOffset + 1], 0.5f);
  EXPECT_EQ(state.parameters[3 * 9 + kDensityOffset], std::log(3.5f));
  EXPECT_EQ(state.parameters[kDensityOffset], kLeastLogDensity) << "density 0 has no logarithm";
  EXPECT_EQ(state.parameters[9 + kStandardComponents + 2], field.others[0].values[5 + 2]);
  EXPECT_EQ(state.first_moment, std::vector<float>(4 * 4, 0.0f));
  EXPECT_EQ(state.second_moment, std::vector<float>(4 * 5, 0.0f)) << "one of the other attribute";
}

TEST(FieldState, KeepsTheSignsOfSignedDensity) {
  RadianceField field = OneTetWithExtraValues();
  field.density = {-4, 0, 1, 50};
  const FieldState state = StateOf(field, SignedDensity(0.5f));
  EXPECT_EQ(state.parameters[9 + kDensityOffset], 0.0f);
  const RadianceField back = FieldOf(field.mesh, state);
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(back.density[v], field.density[v], 1e-5);
  const RadianceField by_itself = FieldOf(field.mesh, StateOf(field));
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(by_itself.density[v], field.density[v], 1e-5);
  const FieldState between = Prolong(state, {.inserted = {{0, 3, 0.5f}}, .kept = {4}});
  EXPECT_NEAR(ValueOf(SignedDensity(0.5f), between.parameters[kDensityOffset]), 23.0f, 1e-4f);
}

TEST(FieldState, BecomesTheFieldAgain) {
  const RadianceField field = OneTetWithExtraValues();
  const RadianceField back = FieldOf(field.mesh, StateOf(field));
  EXPECT_EQ(back.storage, field.storage);
  EXPECT_EQ(back.color_srgb, field.color_srgb);
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(back.density[v], field.density[v], 1e-6);
  ASSERT_EQ(back.others.size(), 1u);
  EXPECT_EQ(back.others[0].attribute, kExtraAttribute);
  EXPECT_EQ(back.others[0].values, field.others[0].values);
}

TEST(Prolong, InterpolatesValuesNotParameters) {
  FieldState state = StateOf(OneTetWithExtraValues());
  for (size_t i = 0; i < state.first_moment.size(); ++i) state.first_moment[i] = float(i);
  for (size_t i = 0; i < state.second_moment.size(); ++i) state.second_moment[i] = 100 + float(i);
  const FieldState result = Prolong(state, {.inserted = {{1, 3, 0.25f}}, .kept = {2, 4}});
  ASSERT_EQ(result.layout, state.layout);
  ASSERT_EQ(result.rows(), 2u);
  ASSERT_EQ(result.first_moment.size(), 2u * 4);
  ASSERT_EQ(result.second_moment.size(), 2u * 5);
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(result.first_moment[c], state.first_moment[2 * 4 + c]) << "copied";
    EXPECT_EQ(result.first_moment[4 + c], float(4 + c) + 0.25f * 8.0f);
  }
  for (size_t c = 0; c < 5; ++c) {
    EXPECT_EQ(result.second_moment[5 + c], 100.0f + float(5 + c) + 0.25f * 10.0f);
  }
  for (size_t c = 0; c < 9; ++c) {
    EXPECT_EQ(result.parameters[c], state.parameters[2 * 9 + c]) << "copied";
    if (c == kDensityOffset) continue;
    const float a = state.parameters[9 + c], b = state.parameters[3 * 9 + c];
    EXPECT_FLOAT_EQ(result.parameters[9 + c], 0.75f * a + 0.25f * b);
  }
  // 0.75 x 1 + 0.25 x 3.5; two roundings of exp and log.
  EXPECT_NEAR(std::exp(result.parameters[9 + kDensityOffset]), 1.625f, 1e-6f);
}

TEST(Prolong, InsertsRowsBetweenInsertedOnes) {
  const FieldState state = StateOf(OneTetWithExtraValues());
  // Row 5 is 3/4 row 0, 1/4 row 2.
  const Prolongation twice{.inserted = {{0, 2, 0.5f}, {0, 4, 0.5f}}, .kept = {5, 1}};
  const FieldState result = Prolong(state, twice);
  ASSERT_EQ(result.rows(), 2u);
  for (size_t c = 0; c < 3; ++c) {
    const float mixed = 0.75f * state.parameters[c] + 0.25f * state.parameters[2 * 9 + c];
    EXPECT_FLOAT_EQ(result.parameters[c], mixed);
    EXPECT_EQ(result.parameters[9 + c], state.parameters[9 + c]);
  }
  EXPECT_EQ(Prolong(std::vector<float>{1, 2, 5, 3}, twice), (std::vector<float>{2, 2}));
}

}  // namespace
}  // namespace tetrec
