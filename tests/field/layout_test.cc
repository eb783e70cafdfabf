// The description of what a row of a field carries.
#include "field/layout.h"

#include "core/error.h"
#include "expect_error.h"
#include "field/extra_attribute.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

TEST(FieldLayout, OfTheStandardIsColourAndTheLogarithmOfDensity) {
  const FieldLayout layout;
  EXPECT_TRUE(layout.IsStandard());
  EXPECT_EQ(layout.Components(), kStandardComponents);
  EXPECT_EQ(layout.OffsetOf("color"), kColorOffset);
  EXPECT_EQ(layout.OffsetOf("density"), kDensityOffset);
  EXPECT_EQ(layout.ParameterNames(),
            (std::vector<std::string>{"color[0]", "color[1]", "color[2]", "log density"}));
  EXPECT_THROW(layout.OffsetOf("extra"), BugError);
}

TEST(FieldLayout, CountsWhatComesBehindDensity) {
  const FieldLayout layout = WithExtra({});
  EXPECT_FALSE(layout.IsStandard());
  EXPECT_EQ(layout.Components(), 9);
  EXPECT_EQ(layout.OffsetOf("extra"), 4);
  EXPECT_EQ(layout.ParameterNames().back(), "extra[4]");
  EXPECT_EQ(layout.ByComponent()[3]->name, "density");
  EXPECT_EQ(layout.ByComponent()[8]->name, "extra");
}

void ExpectRefused(const std::string& message, const std::vector<Attribute>& attributes) {
  FieldLayout layout;
  layout.attributes = attributes;
  ExpectError<DataError>([&] { CheckLayout(layout); }, {message});
}

TEST(FieldLayout, RefusesWhatNoKernelOrFileCouldMean) {
  EXPECT_NO_THROW(CheckLayout(WithExtra(kCellLayout)));
  ExpectRefused("start with colour", {kDensityAttribute, kExtraAttribute});
  ExpectRefused("start with colour", {kDensityAttribute, kColorAttribute});
  ExpectRefused("start with colour", {kColorAttribute});
  ExpectRefused("8 attributes at most", std::vector<Attribute>(9, kColorAttribute));
  const auto third = [](const Attribute& attribute) {
    return std::vector<Attribute>{kColorAttribute, kDensityAttribute, attribute};
  };
  ExpectRefused("name of attribute 2", third({"", 1}));
  ExpectRefused("name of attribute 2", third({"a b", 1}));
  ExpectRefused("name of attribute 2", third({std::string(33, 'a'), 1}));
  ExpectRefused("'extra' has 0 components", third({"extra", 0}));
  ExpectRefused("'extra' has 65 components", third({"extra", 65}));
  ExpectRefused("activation 5", third({"extra", 5, Activation(5), RateClass::kColor}));
  ExpectRefused("'extra' is signed",
                third({"extra", 1, Activation::kSigned, RateClass::kColor, 1}));
  ExpectRefused("'extra' is softplus",
                third({"extra", 1, Activation::kSoftplus, RateClass::kColor, 1}));
  for (const float scale : {0.0f, -1.0f, 1e-30f, INFINITY, NAN}) {
    ExpectRefused("density of vertices can be signed", {kColorAttribute, SignedDensity(scale)});
    ExpectRefused("only density can be softplus", {kColorAttribute, SoftplusDensity(scale)});
  }
  ExpectRefused("rate class 3", third({"extra", 5, Activation::kExp, RateClass(3)}));
  ExpectRefused("two attributes 'density'", third({"density", 2}));
}

TEST(FieldLayout, ReadsBackAsItWasWritten) {
  FieldLayout with_sign;
  with_sign.attributes[1] = SignedDensity(2.5f);
  FieldLayout softplus_cells = kCellLayout;
  softplus_cells.attributes[1] = SoftplusDensity(2.5f);
  for (const FieldLayout& layout : {FieldLayout{}, kCellLayout, WithExtra(kCellLayout), with_sign,
                                    WithExtra(with_sign), softplus_cells}) {
    ByteWriter writer;
    AppendLayout(writer, layout);
    ByteReader reader(writer.bytes(), "file");
    EXPECT_EQ(TakeLayout(reader), layout);
    EXPECT_NO_THROW(reader.ExpectEnd());
  }
}

TEST(FieldLayout, RefusesHugeCountsAndPrefixes) {
  ByteWriter writer;
  AppendLayout(writer, WithExtra({}));
  const std::vector<uint8_t> good = writer.bytes();
  const auto read = [](std::span<const uint8_t> bytes) {
    ByteReader reader(bytes, "file");
    return TakeLayout(reader);
  };
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW(read(std::span(good).first(size)), DataError) << size;
  }
  // Storage, attributes, letters of the first name, its components, activation and rate class.
  for (const size_t at : {0, 4, 8, 17, 21, 25}) {
    for (const uint32_t value : {100u, 1u << 31, ~0u}) {
      std::vector<uint8_t> bytes = good;
      std::memcpy(bytes.data() + at, &value, sizeof(value));
      EXPECT_THROW(read(bytes), DataError) << at << ": " << value;
    }
  }
}

const Attribute kIdentity{"extra", 1};
const Attribute kSigned = SignedDensity(2.0f), kSoftplus = SoftplusDensity(2.0f);

TEST(Activation, GoesThereAndBack) {
  for (const float value : {1e-30f, 0.25f, 1.0f, 1e5f}) {
    for (const Attribute& attribute :
         {kIdentity, kColorAttribute, kDensityAttribute, kSigned, kSoftplus}) {
      const float back = ValueOf(attribute, ParameterOf(attribute, value));
      // The logarithm, below 70, is rounded to 4e-6.
      EXPECT_NEAR(back, value, 4e-6f * value);
    }
    EXPECT_NEAR(ValueOf(kSigned, ParameterOf(kSigned, -value)), -value, 4e-6f * value);
  }
  EXPECT_EQ(ParameterOf(kDensityAttribute, 0.0f), kLeastLogDensity);
  EXPECT_EQ(ParameterOf(kDensityAttribute, -1.0f), kLeastLogDensity);
  EXPECT_EQ(ParameterOf(kSoftplus, 0.0f), kLeastLogDensity);
  EXPECT_EQ(ParameterOf(kSoftplus, -1.0f), kLeastLogDensity);
  EXPECT_EQ(SlopeOf(kIdentity, 3.0), 1.0);
}

TEST(Activation, HasTheSlopeOfItsValues) {
  for (const Attribute& attribute : {kDensityAttribute, kSigned, kSoftplus}) {
    for (const double parameter : {-3.0, -0.5, 0.0, 0.1, 4.0}) {
      const double h = 1e-5;
      const double slope =
          (ValueOf(attribute, parameter + h) - ValueOf(attribute, parameter - h)) / (2 * h);
      EXPECT_NEAR(SlopeOf(attribute, parameter), slope, 1e-8 * slope);
    }
  }
}

TEST(Activation, OfSoftplusDensityIsExponentialBelowItsScaleAndLinearAbove) {
  EXPECT_NEAR(ValueOf(kSoftplus, -10.0), 2 * std::exp(-10.0), 1e-4 * 2 * std::exp(-10.0));
  EXPECT_NEAR(ValueOf(kSoftplus, 50.0), 2 * 50.0, 1e-9);
  EXPECT_EQ(ValueOf(kSoftplus, 1e4f), 2e4f);
}

TEST(Activation, KeepsParametersInBounds) {
  const ParameterBounds logs = BoundsOf(kDensityAttribute, 100.0f);
  EXPECT_EQ(logs.least, kLeastLogDensity);
  EXPECT_EQ(logs.largest, std::log(100.0f));
  const ParameterBounds bounds = BoundsOf(kSigned, 100.0f);
  EXPECT_LT(ValueOf(kSigned, bounds.least), -10.0f);
  EXPECT_NEAR(ValueOf(kSigned, bounds.largest), 100.0f, 1e-3f);
  EXPECT_EQ(BoundsOf(kSoftplus, 100.0f).least, kLeastLogDensity);
  EXPECT_NEAR(ValueOf(kSoftplus, BoundsOf(kSoftplus, 100.0f).largest), 100.0f, 1e-3f);
}

}  // namespace
}  // namespace tetrec
