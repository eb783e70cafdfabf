// PLY: round trips, other programs' files, hostile files.
#include "core/ply.h"

#include "core/error.h"
#include "core/file.h"
#include "core/message_of.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

namespace tetrec {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PlyFile Parse(const std::string& text) {
  return ParsePly({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, "test.ply");
}

PlyProperty Scalars(const char* name, PlyType type, std::vector<double> values) {
  return {name, type, false, PlyType::kUint8, std::move(values), {}};
}

// Extreme values of every type, and lists of several lengths, including an empty one.
PlyFile Example() {
  PlyFile file;
  file.comments = {"made by a test"};
  PlyElement vertex{"vertex", 3, {}};
  vertex.properties = {Scalars("a", PlyType::kInt8, {-128, 0, 127}),
                       Scalars("b", PlyType::kUint8, {0, 1, 255}),
                       Scalars("c", PlyType::kInt16, {-32768, 0, 32767}),
                       Scalars("d", PlyType::kUint16, {0, 1, 65535}),
                       Scalars("e", PlyType::kInt32, {-2147483648.0, 0, 2147483647}),
                       Scalars("f", PlyType::kUint32, {0, 1, 4294967295.0}),
                       Scalars("g", PlyType::kFloat, {-0.5, 0, std::numeric_limits<float>::max()}),
                       Scalars("h", PlyType::kDouble, {0.1, -1e300, 5e-324})};
  PlyElement face{"face", 2, {}};
  face.properties = {{"vertex_indices", PlyType::kInt32, true, PlyType::kUint8, {0, 1, 2}, {3, 0}},
                     Scalars("quality", PlyType::kFloat, {1, 2})};
  file.elements = {vertex, face, PlyElement{"nothing", 0, {}}};
  return file;
}

void ExpectSame(const PlyFile& a, const PlyFile& b) {
  EXPECT_EQ(a.comments, b.comments);
  ASSERT_EQ(a.elements.size(), b.elements.size());
  for (size_t e = 0; e < a.elements.size(); ++e) {
    EXPECT_EQ(a.elements[e].name, b.elements[e].name);
    EXPECT_EQ(a.elements[e].count, b.elements[e].count);
    ASSERT_EQ(a.elements[e].properties.size(), b.elements[e].properties.size());
    for (size_t p = 0; p < a.elements[e].properties.size(); ++p) {
      const PlyProperty &x = a.elements[e].properties[p], &y = b.elements[e].properties[p];
      EXPECT_EQ(x.name, y.name);
      EXPECT_EQ(x.type, y.type);
      EXPECT_EQ(x.values, y.values) << x.name;
      EXPECT_EQ(x.list_sizes, y.list_sizes) << x.name;
    }
  }
}

TEST(Ply, WhatIsWrittenIsReadAgain) {
  const ScratchFolder folder;
  WritePly(folder / "a.ply", Example());
  ExpectSame(ReadPly(folder / "a.ply"), Example());
}

RC_GTEST_PROP(Ply, AnyFloatsAndListsComeBack, (const std::vector<std::vector<int16_t>>& lists)) {
  PlyElement element{"e", lists.size(), {}};
  PlyProperty list{"l", PlyType::kInt16, true, PlyType::kUint32, {}, {}};
  for (const auto& values : lists) {
    list.list_sizes.push_back(uint32_t(values.size()));
    list.values.insert(list.values.end(), values.begin(), values.end());
  }
  element.properties = {list};
  const ScratchFolder folder;
  WritePly(folder / "a.ply", {{}, {element}});
  const PlyFile read = ReadPly(folder / "a.ply");
  RC_ASSERT(read.elements[0].properties[0].values == list.values);
  RC_ASSERT(read.elements[0].properties[0].list_sizes == list.list_sizes);
}

TEST(Ply, AsciiIsReadWithAnyLineBreaksAndSpaces) {
  const PlyFile file = Parse(
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info x\r\nelement vertex 2\r\nproperty "
      "float32 x\r\n"
      "property uchar red\r\nelement face 1\r\nproperty list uint8 int32 "
      "vertex_index\r\nend_header\r\n"
      "1.5e0\t255\r\n  -2 0\r\n3 0 1\n0");
  EXPECT_THAT(file.comments, ElementsAre("by hand"));
  EXPECT_THAT(file.Find("vertex")->Find("x")->values, ElementsAre(1.5, -2));
  EXPECT_THAT(file.Find("face")->Find("vertex_index")->values, ElementsAre(0, 1, 0));
  EXPECT_EQ(file.Find("edge"), nullptr);
  EXPECT_EQ(file.Find("vertex")->Find("y"), nullptr);
}

TEST(Ply, BigEndianFilesContainTheSameNumbers) {
  std::string text =
      "ply\nformat binary_big_endian 1.0\nelement v 1\nproperty float x\nproperty ushort "
      "n\nend_header\n";
  text += std::string("\x3f\xc0\x00\x00\x01\x02", 6);  // 1.5 and 258
  const PlyFile file = Parse(text);
  EXPECT_THAT(file.elements[0].properties[0].values, ElementsAre(1.5));
  EXPECT_THAT(file.elements[0].properties[1].values, ElementsAre(258));
}

TEST(Ply, EveryTruncatedFileIsRefused) {
  const ScratchFolder folder;
  WritePly(folder / "a.ply", Example());
  const std::vector<uint8_t> bytes = ReadBytes(folder / "a.ply");
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(ParsePly(std::span(bytes).first(size), "cut.ply"), DataError) << size << " bytes";
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_THROW(ParsePly(longer, "long.ply"), DataError);
}

TEST(Ply, CountsBeyondTheFileAreRefusedBeforeMemoryIsAllocated) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const char* count : {"100", "4294967295", "4611686018427387904", "18446744073709551615"}) {
      const std::string head =
          fmt::format("ply\nformat {} 1.0\nelement vertex {}\n", format, count);
      EXPECT_THAT(
          MessageOf<DataError>([&] { Parse(head + "property float x\nend_header\n1 2 3 4"); }),
          HasSubstr("do not fit"));
      EXPECT_THAT(MessageOf<DataError>(
                      [&] { Parse(head + "property list int int x\nend_header\n1 2 3 4"); }),
                  HasSubstr("do not fit"));
      EXPECT_THAT(MessageOf<DataError>([&] { Parse(head + "end_header\n1 2 3 4"); }),
                  HasSubstr("test.ply: the element vertex has no properties"));
    }
  }
  const std::string list =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uint int x\nend_header\n4294967295 0 1";
  EXPECT_THAT(MessageOf<DataError>([&] { Parse(list); }), HasSubstr("do not fit"));
  EXPECT_THAT(MessageOf<DataError>([&] {
                Parse(
                    "ply\nformat ascii 1.0\nelement face 1\nproperty list int int x\n"
                    "end_header\n-1 0");
              }),
              HasSubstr("test.ply: a list of x has the length -1"));
}

TEST(Ply, WrongHeadersAndNumbersAreNamed) {
  const auto message = [](const std::string& text) {
    return MessageOf<DataError>([&] { Parse(text); });
  };
  EXPECT_THAT(message("plx\n"), HasSubstr("test.ply: line 1: is not a PLY file"));
  EXPECT_THAT(message("ply\nformat ascii 2.0\n"), HasSubstr("line 2: expected \"format ascii|"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v 1\n"),
              HasSubstr("test.ply: the PLY header does not end"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelements v 1\n"),
              HasSubstr("line 3: unknown keyword \"elements\""));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v\n"),
              HasSubstr("line 3: expected \"element NAME COUNT\""));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v 1\nproperty list int x\n"),
              HasSubstr("line 4: expected \"property TYPE NAME\" or"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nproperty float x\n"),
              HasSubstr("before any element"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v -1\n"), HasSubstr("\"-1\" is not a count"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v 99999999999999999999999\n"),
              HasSubstr("is not a count"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v 1\nproperty half x\n"),
              HasSubstr("\"half\" is not a PLY type"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nelement v 1\nproperty list float int x\n"),
              HasSubstr("integer"));
  const std::string head = "ply\nformat ascii 1.0\nelement v 1\nproperty uchar x\nend_header\n";
  for (const char* value : {"256", "-1", "1.5", "x", "nan", "0x10"}) {
    EXPECT_THAT(
        message(head + value),
        HasSubstr(fmt::format("byte 0 of its data: \"{}\" is not a valid uchar for x", value)));
  }
  EXPECT_THAT(message(head + " \n"), HasSubstr("ends at byte 2 of its data where x was expected"));
  EXPECT_THAT(message(head + "1 2"), HasSubstr("byte 2 of its data: 1 bytes are left over"));
  const std::string list =
      "ply\nformat ascii 1.0\nelement v 1\nproperty list char int x\nend_header\n";
  EXPECT_THAT(message(list + "-1 0"), HasSubstr("test.ply: a list of x has the length -1"));
}

// A value that does not fit its type is a bug: it must not be written as another value.
TEST(Ply, ValuesThatDoNotFitTheirTypeAreNotWritten) {
  const ScratchFolder folder;
  for (const double value : {256.0, -1.0, 0.5, std::numeric_limits<double>::quiet_NaN()}) {
    const PlyFile file{{}, {PlyElement{"v", 1, {Scalars("x", PlyType::kUint8, {value})}}}};
    EXPECT_THROW(WritePly(folder / "a.ply", file), BugError) << value;
  }
  const PlyFile missing{{}, {PlyElement{"v", 2, {Scalars("x", PlyType::kUint8, {1})}}}};
  EXPECT_THROW(WritePly(folder / "a.ply", missing), BugError);
}

}  // namespace
}  // namespace tetrec
