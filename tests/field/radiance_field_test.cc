#include "field/radiance_field.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "field/extra_attribute.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace tetrec {
namespace {

RadianceField OneTet() {
  RadianceField field;
  field.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  field.density = {0, 1, 2, 3.5f};
  field.color_srgb = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.1f, 0.5f, 1.1f}};
  return field;
}

RadianceField OneCell() {
  RadianceField field = OneTet();
  field.storage = FieldStorage::kCell;
  field.density = {3.5f};
  field.color_srgb = {{-0.1f, 0.5f, 1.1f}};
  return field;
}

RadianceField WithValuesOf(const Attribute& attribute, RadianceField field) {
  field.others = {{attribute, {}}};
  for (size_t i = 0; i < size_t(attribute.components) * RowCount(field); ++i) {
    field.others[0].values.push_back(float(i) - 3.25f);
  }
  return field;
}

RadianceField WithExtraValues(RadianceField field) {
  return WithValuesOf(kExtraAttribute, std::move(field));
}

std::vector<RadianceField> EveryKind() {
  std::vector<RadianceField> fields = {OneTet(), OneCell(), WithExtraValues(OneTet()),
                                       WithExtraValues(OneCell())};
  for (int degree = 1; degree <= kMostHarmonicsDegree; ++degree) {
    fields.push_back(WithValuesOf(HarmonicsAttribute(degree), OneTet()));
    fields.push_back(WithValuesOf(HarmonicsAttribute(degree), OneCell()));
  }
  return fields;
}

std::vector<uint8_t> BytesOf(const RadianceField& field) {
  const ScratchFolder folder;
  WriteField(folder / "field.tetf", field);
  return ReadBytes(folder / "field.tetf");
}

TEST(RadianceFieldFile, ReadsBackAsItWasWritten) {
  for (const RadianceField& field : EveryKind()) {
    const RadianceField read = ParseField(BytesOf(field), "field.tetf");
    EXPECT_EQ(read.storage, field.storage);
    EXPECT_EQ(read.mesh.positions, field.mesh.positions);
    EXPECT_EQ(read.mesh.tets, field.mesh.tets);
    EXPECT_EQ(read.mesh.neighbors, field.mesh.neighbors);
    EXPECT_EQ(read.density, field.density);
    EXPECT_EQ(read.color_srgb, field.color_srgb);
    ASSERT_EQ(read.others.size(), field.others.size());
    for (size_t i = 0; i < field.others.size(); ++i) {
      EXPECT_EQ(read.others[i].attribute, field.others[i].attribute);
      EXPECT_EQ(read.others[i].values, field.others[i].values);
    }
  }
}

TEST(RadianceFieldFile, HasTheOldVersionsBytesWhereTheLayoutIsTheStandardOne) {
  const auto magic = [](const RadianceField& field) {
    const std::vector<uint8_t> bytes = BytesOf(field);
    return std::string(bytes.begin(), bytes.begin() + 8);
  };
  EXPECT_EQ(magic(OneTet()), "TETRECF1");
  EXPECT_EQ(magic(OneCell()), "TETRECF2");
  EXPECT_EQ(magic(WithExtraValues(OneTet())), "TETRECF3");
  EXPECT_EQ(magic(WithExtraValues(OneCell())), "TETRECF3");
  // Behind the magic the mesh: its own magic, two counts, 4 positions, a tet and its neighbours.
  const std::vector<uint8_t> bytes = BytesOf(OneTet());
  const size_t density_at = 8 + 8 + 16 + 4 * 12 + 16 + 16;
  ASSERT_EQ(bytes.size(), density_at + 4 * 4 + 4 * 12);
  float last_density = 0;
  std::memcpy(&last_density, bytes.data() + density_at + 12, 4);
  EXPECT_EQ(last_density, 3.5f);
}

TEST(RadianceFieldFile, RefusesAnotherLayoutThanThatOfItsValues) {
  const std::vector<uint8_t> good = BytesOf(WithExtraValues(OneTet()));
  // Behind the magic: storage, attributes, "color" and "density" with 12 bytes each, "extra".
  const size_t storage_at = 8, count_at = 12, components_at = 16 + (4 + 5 + 12) + (4 + 7 + 12) + 9;
  for (const size_t at : {storage_at, count_at, components_at}) {
    for (const uint32_t value : {0u, 1u, 2u, 4u, 6u, 64u, 100u, ~0u}) {
      std::vector<uint8_t> bytes = good;
      if (std::memcmp(bytes.data() + at, &value, 4) == 0) continue;
      std::memcpy(bytes.data() + at, &value, 4);
      EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError) << at << ": " << value;
    }
  }
}

TEST(RadianceFieldFile, RefusesAttributesOfTheOtherStorage) {
  for (const RadianceField& field : {OneTet(), OneCell()}) {
    std::vector<uint8_t> bytes = BytesOf(field);
    bytes[7] = bytes[7] == '1' ? '2' : '1';
    EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError);
    bytes[7] = '3';
    EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError);
    bytes[7] = '4';
    ExpectError<DataError>([&] { ParseField(bytes, "field.tetf"); },
                           {"field.tetf: is a radiance field of format version '4'"});
  }
}

TEST(RadianceFieldFile, RefusesEveryPrefixAndTrailingBytes) {
  for (const RadianceField& field : EveryKind()) {
    std::vector<uint8_t> bytes = BytesOf(field);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_THROW(ParseField(std::span(bytes).first(size), "field.tetf"), DataError) << size;
    }
    bytes.push_back(0);
    EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError);
  }
}

TEST(RadianceFieldFile, RefusesHugeCounts) {
  for (const RadianceField& field : {OneTet(), OneCell()}) {
    const std::vector<uint8_t> good = BytesOf(field);
    for (const size_t at : {size_t{16}, size_t{24}}) {  // behind the two magics
      for (const uint64_t count : {uint64_t{1} << 32, uint64_t{1} << 62, ~uint64_t{0}}) {
        std::vector<uint8_t> bytes = good;
        std::memcpy(bytes.data() + at, &count, sizeof(count));
        EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError);
      }
    }
  }
}

TEST(CheckField, RefusesNegativeAndNonFiniteValues) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto refused = [](const char* message, auto&& damage) {
    RadianceField field = OneTet();
    damage(field);
    ExpectError<DataError>([&] { CheckField(field); }, {message});
  };
  EXPECT_NO_THROW(CheckField(OneTet()));
  RadianceField with_sign = OneTet();
  with_sign.density[1] = -1e-9f;
  EXPECT_NO_THROW(CheckField(with_sign));
  refused("density of vertex 3 is nan", [](RadianceField& f) { f.density[3] = kNan; });
  refused("density of vertex 3 is inf", [](RadianceField& f) { f.density[3] = kInfinity; });
  refused("colour of vertex 2 is not finite: (0, 1, nan)",
          [](RadianceField& f) { f.color_srgb[2].b = kNan; });
  refused("4 vertices but 3 densities and 4 colours",
          [](RadianceField& f) { f.density.pop_back(); });
  refused("4 vertices but 4 densities and 5 colours",
          [](RadianceField& f) { f.color_srgb.emplace_back(0.0f); });
  refused("1 tets but 4 densities and 4 colours",
          [](RadianceField& f) { f.storage = FieldStorage::kCell; });
  EXPECT_NO_THROW(CheckField(OneCell()));
  const auto refused_with_extra = [](const char* message, auto&& damage) {
    RadianceField field = WithExtraValues(OneTet());
    damage(field.others);
    ExpectError<DataError>([&] { CheckField(field); }, {message});
  };
  EXPECT_NO_THROW(CheckField(WithExtraValues(OneCell())));
  refused_with_extra("'extra' has 19 values, must have 5 for each vertex",
                     [](auto& others) { others[0].values.pop_back(); });
  refused_with_extra("'extra' of vertex 1 is nan",
                     [](auto& others) { others[0].values[7] = kNan; });
  refused_with_extra("'extra' of vertex 0 is -3.25: it must be finite and 0 or more",
                     [](auto& others) { others[0].attribute.activation = Activation::kExp; });
  refused_with_extra("two attributes 'color'",
                     [](auto& others) { others[0].attribute.name = "color"; });
}

TEST(RadianceFieldFile, NamesTheFileOfAFieldThatIsNoGood) {
  RadianceField field = OneCell();
  field.density[0] = -2;
  ExpectError<DataError>([&] { ParseField(BytesOf(field), "field.tetf"); },
                         {"field.tetf: the density of tet 0 is -2"});
}

}  // namespace
}  // namespace tetrec
