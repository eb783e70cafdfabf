#include "field/radiance_field.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
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

std::vector<uint8_t> BytesOf(const RadianceField& field) {
  const ScratchFolder folder;
  WriteField(folder / "field.tetf", field);
  return ReadBytes(folder / "field.tetf");
}

TEST(RadianceFieldFile, ReadsBackAsItWasWritten) {
  for (const RadianceField& field : {OneTet(), OneCell()}) {
    const RadianceField read = ParseField(BytesOf(field), "field.tetf");
    EXPECT_EQ(read.storage, field.storage);
    EXPECT_EQ(read.mesh.positions, field.mesh.positions);
    EXPECT_EQ(read.mesh.tets, field.mesh.tets);
    EXPECT_EQ(read.mesh.neighbors, field.mesh.neighbors);
    EXPECT_EQ(read.density, field.density);
    EXPECT_EQ(read.color_srgb, field.color_srgb);
  }
}

TEST(RadianceFieldFile, RefusesAttributesOfTheOtherStorage) {
  for (const RadianceField& field : {OneTet(), OneCell()}) {
    std::vector<uint8_t> bytes = BytesOf(field);
    bytes[7] = bytes[7] == '1' ? '2' : '1';
    EXPECT_THROW(ParseField(bytes, "field.tetf"), DataError);
    bytes[7] = '3';
    ExpectError<DataError>([&] { ParseField(bytes, "field.tetf"); },
                           {"field.tetf: is a radiance field of format version '3'"});
  }
}

TEST(RadianceFieldFile, RefusesEveryPrefixAndTrailingBytes) {
  for (const RadianceField& field : {OneTet(), OneCell()}) {
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
  refused("density of vertex 1 is -1e-09", [](RadianceField& f) { f.density[1] = -1e-9f; });
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
}

TEST(RadianceFieldFile, NamesTheFileOfAFieldThatIsNoGood) {
  RadianceField field = OneCell();
  field.density[0] = -2;
  ExpectError<DataError>([&] { ParseField(BytesOf(field), "field.tetf"); },
                         {"field.tetf: the density of tet 0 is -2"});
}

}  // namespace
}  // namespace tetrec
