// Transfer functions: both formats, interpolation, refused files, and the form prepared for rays.
#include "volume/transfer_function.h"

#include "core/error.h"
#include "expect_error.h"
#include "image/srgb.h"
#include "volume/shaded_transfer.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

using nlohmann::json;

TransferFunction Parse(const json& file, const glm::dvec2& values_at_0_and_1 = {-1, 3}) {
  return ParseTransferFunction(file, "tf.json", values_at_0_and_1);
}

json Ours() {
  return {{"opacity", {{0.0, 0.0}, {0.5, 0.0}, {0.75, 1.0}}},
          {"colour", {{0.25, 0, 0, 0}, {0.75, 1, 0.5, 0}}}};
}

json ParaView() {
  return json::array({{{"ColorSpace", "RGB"},
                       {"Name", "made by hand"},
                       {"RGBPoints", {-1, 0, 0, 0, 1, 1, 0.5, 0, 3, 1, 1, 1}},
                       {"Points", {-1, 0, 0.5, 0, 3, 1, 0.5, 0}}}});
}

TEST(Srgb, IsInvertible) {
  for (double value = 0; value <= 1; value += 1.0 / 64) {
    EXPECT_NEAR(SrgbFromLinear(LinearFromSrgb(value)), value, 1e-12);
  }
  EXPECT_NEAR(LinearFromSrgb(0.5), 0.21404114, 1e-7);  // IEC 61966-2-1
}

TEST(TransferFunction, OpacityIsLinearBetweenAndConstantBeyondItsPoints) {
  const TransferFunction function = Parse(Ours());
  EXPECT_EQ(function.OpacityAt(0.3), 0);
  EXPECT_NEAR(function.OpacityAt(0.6), 0.4, 1e-15);
  EXPECT_EQ(function.OpacityAt(0.75), 1);
  EXPECT_EQ(function.OpacityAt(1), 1);
}

TEST(TransferFunction, TetrecsColoursAreLinearInLinearRgb) {
  const TransferFunction function = Parse(Ours());
  EXPECT_EQ(function.SrgbAt(0), glm::dvec3(0.0));
  EXPECT_NEAR(function.SrgbAt(0.5).r, SrgbFromLinear(0.5), 1e-12);
  EXPECT_NEAR(function.SrgbAt(0.5).g, SrgbFromLinear(0.5 * LinearFromSrgb(0.5)), 1e-12);
  EXPECT_NEAR(function.SrgbAt(1).g, 0.5, 1e-12);
}

TEST(TransferFunction, ParaViewsColoursAreLinearInSrgbAndItsPositionsAreValuesOfSamples) {
  const TransferFunction function = Parse(ParaView());
  EXPECT_EQ(function.interpolation, ColorInterpolation::kSrgb);
  EXPECT_NEAR(function.OpacityAt(0.25), 0.25, 1e-15);
  EXPECT_NEAR(function.SrgbAt(0.25).g, 0.25, 1e-15);
  EXPECT_NEAR(function.SrgbAt(0.75).b, 0.5, 1e-15);
  // Samples of -5 to 5 extend beyond the map, which is constant there.
  const TransferFunction wider = Parse(ParaView(), {-5, 5});
  EXPECT_EQ(wider.OpacityAt(0.3), 0);
  EXPECT_NEAR(wider.OpacityAt(0.6), 0.5, 1e-15);
  EXPECT_EQ(wider.OpacityAt(0.9), 1);
  // Samples of 0 to 2 cover the middle half of the map.
  const TransferFunction narrower = Parse(ParaView(), {0, 2});
  EXPECT_NEAR(narrower.OpacityAt(0), 0.25, 1e-15);
  EXPECT_NEAR(narrower.OpacityAt(1), 0.75, 1e-15);
  EXPECT_NEAR(narrower.SrgbAt(0.75).b, 0.25, 1e-15);
}

TEST(TransferFunction, OpaqueStretchesAreWhereOpacityIsAboveZero) {
  const auto stretches = [](const std::vector<TransferFunction::OpacityPoint>& opacity) {
    TransferFunction function;
    function.opacity = opacity;
    return function.OpaqueStretches();
  };
  using Stretches = std::vector<glm::dvec2>;
  EXPECT_EQ(stretches({{0.5, 0}}), Stretches());
  EXPECT_EQ(stretches({{0.5, 0.1}}), (Stretches{{0, 1}}));
  EXPECT_EQ(stretches({{0, 0}, {1, 0.1}}), (Stretches{{0, 1}}));
  EXPECT_EQ(stretches({{0.1, 1}, {0.2, 0}, {0.4, 0}, {0.5, 0.3}, {0.6, 0.3}, {0.8, 0}}),
            (Stretches{{0, 0.2}, {0.4, 0.8}}));
  EXPECT_EQ(stretches({{0.3, 0}, {0.9, 1}}), (Stretches{{0.3, 1}}));
}

TEST(TransferFunction, KnowsWhetherItsPositionsAreValues) {
  EXPECT_FALSE(Parse(Ours()).given_in_values);
  EXPECT_TRUE(Parse(ParaView()).given_in_values);
  json normalised = ParaView();
  normalised[0]["RGBPoints"] = {0, 0, 0, 0, 1, 1, 1, 1};
  normalised[0]["Points"] = {0, 0, 0.5, 0, 1, 1, 0.5, 0};
  EXPECT_FALSE(Parse(normalised).given_in_values);
}

TEST(TransferFunction, AParaViewMapOfZeroToOneIsNormalised) {
  json preset = ParaView();
  preset[0]["RGBPoints"] = {0, 0, 0, 0, 1, 1, 1, 1};
  preset[0]["Points"] = {0, 0, 0.5, 0, 1, 1, 0.5, 0};
  EXPECT_NEAR(Parse(preset, {0, 255}).OpacityAt(0.25), 0.25, 1e-15);
}

TEST(TransferFunction, ErrorsNameTheField) {
  // A patch turns the good file into a bad one (null removes a field).
  const auto refused = [](json file, const char* patch, std::initializer_list<std::string> parts) {
    SCOPED_TRACE(patch);
    json& object = file.is_array() ? file[0] : file;
    object.merge_patch(json::parse(patch));
    ExpectError<DataError>([&] { Parse(file); }, parts);
  };
  refused(Ours(), R"({"opacity": null})", {"tf.json", "opacity is missing"});
  refused(Ours(), R"({"opacity": []})", {"opacity has 0 points"});
  refused(Ours(), R"({"opacity": [[0, 0], [0, 1]]})", {"opacity[1][0]", "rise strictly"});
  refused(Ours(), R"({"opacity": [[0.5, 0], [0.25, 1]]})",
          {"opacity[1][0] is 0.25", "rise strictly"});
  refused(Ours(), R"({"opacity": [[0, 1.5]]})", {"opacity[0][1] is 1.5"});
  refused(Ours(), R"({"opacity": [[-1, 1]]})", {"opacity[0][0] is -1"});
  refused(Ours(), R"({"opacity": [[0, "a"]]})", {"opacity[0][1]", "a number"});
  refused(Ours(), R"({"opacity": [[0]]})", {"opacity[0] has 1 numbers", "x, opacity"});
  refused(Ours(), R"({"colour": null})", {"colour is missing"});
  refused(Ours(), R"({"colour": [[0, 0, 0]]})", {"colour[0] has 3 numbers", "x, r, g, b"});
  refused(Ours(), R"({"colour": [[0, 0, 2, 0]]})", {"colour[0][2] is 2"});
  refused(Ours(), R"({"colour": {}})", {"colour", "an array"});
  refused(ParaView(), R"({"ColorSpace": "Lab"})", {"ColorSpace is \"Lab\"", "only \"RGB\""});
  refused(ParaView(), R"({"ColorSpace": null})", {"ColorSpace is missing"});
  refused(ParaView(), R"({"UseLogScale": 1})", {"UseLogScale is on"});
  refused(ParaView(), R"({"RGBPoints": null})", {"RGBPoints is missing"});
  refused(ParaView(), R"({"RGBPoints": [0, 1, 1]})", {"RGBPoints has 3 numbers", "x, r, g, b"});
  refused(ParaView(), R"({"RGBPoints": [0, 1, 7, 1]})", {"RGBPoints[2] is 7"});
  refused(ParaView(), R"({"Points": null})", {"Points is missing"});
  refused(ParaView(), R"({"Points": [0, 1, 0.5]})", {"Points has 3 numbers", "midpoint"});
  refused(ParaView(), R"({"Points": [0, 1, 0.25, 0]})", {"Points[2]", "midpoint"});
  refused(ParaView(), R"({"Points": [0, 1, 0.5, 1]})", {"Points[3]", "sharpness"});
  refused(ParaView(), R"({"Points": [1, 1, 0.5, 0, 0, 1, 0.5, 0]})",
          {"Points[4] is 0", "rise strictly"});
  refused(ParaView(), R"({"Points": [1, 1, 0.5, 0], "RGBPoints": [1, 0, 0, 0]})", {"spans 1 to 1"});
  ExpectError<DataError>([&] { Parse(json::array()); }, {"contains 0 colour maps"});
  ExpectError<DataError>([&] { Parse(7); }, {"tf.json: the whole file is 7; expected an object"});
  // Over such a range, -1 and 3 are the same position in double.
  ExpectError<DataError>(
      [&] {
        Parse(ParaView(), {-1e17, 1e17});
      },
      {"positions too close for samples of -1e+17 to 1e+17"});
}

TEST(ShadedTransfer, AgreesWithItsTransferFunctionEverywhere) {
  for (const json& file : {Ours(), ParaView()}) {
    const TransferFunction function = Parse(file);
    const ShadedTransfer shaded(function);
    for (int i = 0; i <= 9999; ++i) {
      const float x = float(i) / 9999;
      const int piece = shaded.PieceOf(x);
      EXPECT_GE(x, shaded.Knot(piece));
      EXPECT_LE(x, shaded.Knot(piece + 1));
      const float opacity = shaded.OpacityOffset(piece) + shaded.OpacitySlope(piece) * x;
      EXPECT_NEAR(opacity, function.OpacityAt(x), 1e-6);  // a few roundings of float
      EXPECT_TRUE(opacity < 1e-6f || shaded.IsVisible(piece, piece));
      const glm::dvec3 error = glm::abs(glm::dvec3(shaded.SrgbAt(piece, x)) - function.SrgbAt(x));
      EXPECT_LT(std::max({error.r, error.g, error.b}), 1.5 * ShadedTransfer::kColorError) << x;
    }
  }
}

TEST(ShadedTransfer, KnowsWhereThereIsNothingToSee) {
  const ShadedTransfer shaded(Parse(Ours()));  // knots 0, 0.25, 0.5, 0.75, 1
  EXPECT_EQ(shaded.PieceCount(), 4);
  EXPECT_FALSE(shaded.IsVisible(0, 1));
  EXPECT_TRUE(shaded.IsVisible(1, 2));
  EXPECT_EQ(shaded.PieceOf(1), 3);
}

// Fuzzing found an infinite slope here.
TEST(ShadedTransfer, AcceptsAStepBetweenTheSmallestFloats) {
  const ShadedTransfer shaded(
      Parse({{"opacity", {{0, 0}, {3.5e-43, 1}}}, {"colour", {{0, 1, 0, 0}, {1, 0, 0.5, 1}}}}));
  EXPECT_EQ(shaded.PieceOf(0), 0);
  EXPECT_EQ(shaded.OpacityOffset(0) + shaded.OpacitySlope(0) * 0.0f, 0);
  EXPECT_EQ(shaded.SrgbAt(0, 0), glm::vec3(1, 0, 0));
  const int after = shaded.PieceOf(1e-30f);
  EXPECT_EQ(shaded.OpacityOffset(after) + shaded.OpacitySlope(after) * 1e-30f, 1);
}

TEST(ShadedTransfer, AcceptsPointsThatAreEqualInFloat) {
  const ShadedTransfer shaded(
      Parse({{"opacity", {{0.5, 0}, {0.5 + 1e-12, 1}}}, {"colour", {{0, 1, 1, 1}}}}));
  EXPECT_EQ(shaded.PieceCount(), 2);
  EXPECT_EQ(shaded.OpacityOffset(0), 0);
  EXPECT_EQ(shaded.OpacityOffset(1), 1);
}

}  // namespace
}  // namespace tetrec
