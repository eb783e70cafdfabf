// Volume files: all formats and spellings, and refused files.
#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"
#include "volume/reader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <limits>

namespace tetrec {
namespace {

// 2 x 3 x 2 samples of 8 bits: 0, 5, 10, ...
std::string EightBits() {
  std::string bytes;
  for (int i = 0; i < 12; ++i) bytes += char(5 * i);
  return bytes;
}

template <class T>
std::string BytesOfValues(const std::vector<T>& values, bool big_endian) {
  std::string bytes;
  for (const T value : values) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof(T));
    if (big_endian != (std::endian::native == std::endian::big)) {
      std::reverse(raw.begin(), raw.end());
    }
    bytes += raw;
  }
  return bytes;
}

std::string Gzip(const std::string& bytes) {
  std::string packed(bytes.size() + 64, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = uInt(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

constexpr const char* kNrrd =
    "NRRD0004\n# a comment\nkey:=value\ntype: unsigned char\ndimension: 3\nsizes: 2 3 2\n";
constexpr const char* kMeta =
    "ObjectType = Image\nNDims = 3\nDimSize = 2 3 2\nElementType = MET_UCHAR\n";

class VolumeFiles : public ::testing::Test {
 protected:
  VolumeFile Read(const std::string& name, const std::string& content) {
    return ReadVolume(folder_.Write(name, content));
  }
  void ExpectRefused(const std::string& name, const std::string& content,
                     std::initializer_list<std::string> parts) {
    SCOPED_TRACE(content.substr(0, 300));
    ExpectError<DataError>([&] { Read(name, content); }, parts);
  }
  static void ExpectEightBits(const Volume& volume) {
    EXPECT_EQ(volume.size, glm::ivec3(2, 3, 2));
    for (size_t i = 0; i < 12; ++i) EXPECT_FLOAT_EQ(volume.samples[i], 5.0f * float(i) / 255);
    EXPECT_EQ(volume.value_at_0, 0);
    EXPECT_EQ(volume.value_at_1, 255);
  }
  ScratchFolder folder_;
};

TEST_F(VolumeFiles, RawSamplesOfEveryTypeAndByteOrder) {
  VolumeLayout layout;
  layout.size = {2, 3, 2};
  ExpectEightBits(ReadRawVolume(folder_.Write("a.raw", EightBits()), layout).volume);

  std::vector<uint16_t> words;
  std::vector<float> floats;
  for (int i = 0; i < 12; ++i) {
    words.push_back(uint16_t(5000 * i));
    floats.push_back(float(i) * 0.5f - 2);
  }
  for (const bool big : {false, true}) {
    layout.big_endian = big;
    layout.type = SampleType::kUint16;
    const Volume sixteen =
        ReadRawVolume(folder_.Write("b.raw", BytesOfValues(words, big)), layout).volume;
    EXPECT_FLOAT_EQ(sixteen.samples[3], 15000.0f / 65535);
    layout.type = SampleType::kInt16;  // 55000 is -10536
    const Volume with_signs =
        ReadRawVolume(folder_.Write("b.raw", BytesOfValues(words, big)), layout).volume;
    EXPECT_EQ(with_signs.least_value, 35000 - 65536);
    EXPECT_EQ(with_signs.value_at_0, -32768);
    EXPECT_FLOAT_EQ(with_signs.samples[11], 22232.0f / 65535);
    EXPECT_FLOAT_EQ(with_signs.samples[3], 47768.0f / 65535);
    layout.type = SampleType::kFloat32;
    const Volume real =
        ReadRawVolume(folder_.Write("c.raw", BytesOfValues(floats, big)), layout).volume;
    EXPECT_EQ(real.value_at_0, -2);
    EXPECT_EQ(real.value_at_1, 3.5);
    EXPECT_EQ(real.samples[0], 0);
    EXPECT_FLOAT_EQ(real.samples[4], 4.0f / 11);
    EXPECT_EQ(real.samples[11], 1);
  }
}

TEST_F(VolumeFiles, RawSamplesMustMatchTheLayoutInNumber) {
  VolumeLayout layout;
  layout.size = {2, 3, 3};
  const auto path = folder_.Write("a.raw", EightBits());
  ExpectError<DataError>(
      [&] { ReadRawVolume(path, layout); },
      {"a.raw", "has 12 bytes", "2 x 3 x 3", "uint8", "18", "check the dimensions"});
  layout.size = {2, 3, 1};
  ExpectError<DataError>([&] { ReadRawVolume(path, layout); }, {"1 samples along z", "2 to"});
  layout.size = {65536, 65536, 65536};
  ExpectError<DataError>([&] { ReadRawVolume(path, layout); },
                         {"65536 x 65536 x 65536", "at most"});
  ExpectError<DataError>([&] { ReadRawVolume(folder_ / "none.raw", {{2, 3, 2}}); }, {"none.raw"});
}

TEST_F(VolumeFiles, FloatSamplesMustBeFiniteAndDiffer) {
  VolumeLayout layout;
  layout.size = {2, 2, 2};
  layout.type = SampleType::kFloat32;
  std::vector<float> values = {0, 1, 2, 3, 4, NAN, 6, INFINITY};
  ExpectError<DataError>(
      [&] { ReadRawVolume(folder_.Write("a.raw", BytesOfValues(values, false)), layout); },
      {"2 samples are not finite", "(1, 0, 1)"});
  values.assign(8, 3);
  ExpectError<DataError>(
      [&] { ReadRawVolume(folder_.Write("a.raw", BytesOfValues(values, false)), layout); },
      {"all samples are 3"});
  // The range itself overflows float.
  constexpr float kMax = std::numeric_limits<float>::max();
  values = {-kMax, kMax, 0, 0, 0, 0, 0, 0};
  const Volume wide =
      ReadRawVolume(folder_.Write("a.raw", BytesOfValues(values, false)), layout).volume;
  EXPECT_EQ(wide.samples[0], 0);
  EXPECT_EQ(wide.samples[1], 1);
  EXPECT_EQ(wide.samples[2], 0.5f);
}

TEST_F(VolumeFiles, AValueRangeDefinesWhatBecomesZeroAndOne) {
  VolumeLayout layout;
  layout.size = {2, 2, 2};
  layout.type = SampleType::kUint16;
  const std::vector<uint16_t> words = {0, 100, 200, 300, 400, 500, 600, 4095};
  const auto path = folder_.Write("a.raw", BytesOfValues(words, false));
  const Volume twelve = ReadRawVolume(path, layout, glm::dvec2(100, 500)).volume;
  EXPECT_EQ(twelve.samples, (std::vector<float>{0, 0, 0.25f, 0.5f, 0.75f, 1, 1, 1}));
  EXPECT_EQ(twelve.clamped, 3u);
  EXPECT_EQ(twelve.value_at_0, 100);
  EXPECT_EQ(twelve.value_at_1, 500);
  EXPECT_EQ(twelve.least_value, 0);
  EXPECT_EQ(twelve.largest_value, 4095);
  // Without it the type decides, and no sample can be outside.
  const Volume plain = ReadRawVolume(path, layout).volume;
  EXPECT_EQ(plain.samples[7], 4095.0f / 65535);
  EXPECT_EQ(plain.clamped, 0u);
  EXPECT_EQ(plain.largest_value, 4095);

  // For float it replaces the range of the data, so that all samples may be equal.
  layout.type = SampleType::kFloat32;
  const auto real = folder_.Write("b.raw", BytesOfValues(std::vector<float>(8, -750), false));
  const Volume even = ReadRawVolume(real, layout, glm::dvec2(-1000, 0)).volume;
  EXPECT_EQ(even.samples, std::vector<float>(8, 0.25f));
  ExpectError<DataError>([&] { ReadRawVolume(real, layout); },
                         {"all samples are -750", "value range"});

  // It applies to every format.
  const auto nrrd = folder_.Write("a.nrrd", std::string(kNrrd) + "encoding: raw\n\n" + EightBits());
  EXPECT_EQ(ReadVolume(nrrd, glm::dvec2(0, 20)).volume.clamped, 7u);
  const auto packed =
      folder_.Write("b.nrrd", std::string(kNrrd) + "encoding: gzip\n\n" + Gzip(EightBits()));
  EXPECT_EQ(ReadVolume(packed, glm::dvec2(0, 20)).volume.clamped, 7u);
  const auto meta =
      folder_.Write("a.mha", std::string(kMeta) + "ElementDataFile = LOCAL\n" + EightBits());
  EXPECT_EQ(ReadVolume(meta, glm::dvec2(0, 20)).volume.clamped, 7u);
}

TEST_F(VolumeFiles, NrrdEndsGiveSpacingAndOrigin) {
  // 2 x 3 x 2 samples.
  const auto expect = [&](const std::string& fields, const glm::dvec3& spacing,
                          const glm::dvec3& origin) {
    SCOPED_TRACE(fields);
    const VolumeFile file =
        Read("a.nrrd", std::string(kNrrd) + fields + "encoding: raw\n\n" + EightBits());
    EXPECT_EQ(file.volume.spacing, spacing);
    EXPECT_EQ(file.volume.origin, origin);
    EXPECT_EQ(file.unused_fields.size(), 0u);
  };
  const std::string ends = "axis mins: -1 0 4\naxis maxs: 1 6 8\n";
  // The ends are the first and last sample, or the far sides of their cells.
  expect(ends + "centerings: node node node\n", {2, 3, 4}, {-1, 0, 4});
  expect(ends + "centers: cell cell cell\n", {1, 2, 2}, {-0.5, 1, 5});
  expect(ends + "centers: Cell node CELL\n", {1, 3, 2}, {-0.5, 0, 5});
  expect("axismins: -1 0 4\naxismaxs: 1 6 8\ncenters: cell cell cell\n", {1, 2, 2}, {-0.5, 1, 5});
  // Spacings may repeat this, also rounded.
  expect(ends + "spacings: 2 3 4\ncenters: node node node\n", {2, 3, 4}, {-1, 0, 4});
  expect(ends + "spacings: 1.0001 2 2\ncenters: cell cell cell\n", {1.0001, 2, 2},
         {-1 + 0.5 * 1.0001, 1, 5});
  // They decide what the ends are if nothing else does.
  expect(ends + "spacings: 2 2 4\n", {2, 2, 4}, {-1, 1, 4});
  expect(ends + "spacings: 2 2 4\ncenters: ??? none ???\n", {2, 2, 4}, {-1, 1, 4});
  // They may replace the other end.
  expect("axis mins: -1 0 4\nspacings: 2 2 4\ncenters: node cell node\n", {2, 2, 4}, {-1, 1, 4});
}

TEST_F(VolumeFiles, NrrdEndsThatAreIncompleteOrContradictoryAreRefused) {
  const auto refused = [&](const std::string& fields, std::initializer_list<std::string> parts) {
    ExpectRefused("a.nrrd", std::string(kNrrd) + fields + "encoding: raw\n\n" + EightBits(), parts);
  };
  const std::string ends = "axis mins: -1 0 4\naxis maxs: 1 6 8\n";
  const std::string cells = "centers: cell cell cell\n";
  refused(ends, {"line 7: axis mins", "centerings beside it", "node or cell"});
  refused(ends + "centers: cell none cell\n", {"centerings beside it"});
  refused("axis mins: 0 0 0\nspacings: 1 1 1\n", {"centerings beside it"});
  refused(ends + "centers: cell cell\n", {"centers", "each of the three axes"});
  refused(ends + "centers: cell cell edge\n", {"centers", "each of the three axes"});
  refused("axis mins: 0 0 0\n" + cells, {"axis mins", "axis maxs or spacings beside it"});
  refused("axis maxs: 0 0 0\nspacings: 1 1 1\n" + cells, {"axis maxs", "axis mins beside it"});
  refused("axis mins: 0 0 0\naxis maxs: 1 -1 1\n" + cells, {"axis maxs", "mirrored axes"});
  refused("axis mins: 0 0 0\naxis maxs: 1 nan 1\n" + cells, {"axis maxs", "three numbers"});
  // The spacings imply nodes where the header states cells; or they fit neither.
  refused(ends + "spacings: 2 3 4\n" + cells,
          {"axis mins", "agree with spacings", "are 2, axis mins and maxs give 1"});
  refused(ends + "spacings: 1 5 4\n", {"axis mins", "agree with spacings"});
  refused(ends + "spacings: 1 0 4\n", {"axis mins", "agree with spacings"});
  refused(ends + cells + "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
          {"axis mins", "either this or space directions"});
  refused(ends + cells + "spaceorigin: (1,0,0)\n", {"axis mins", "either this or spaceorigin"});
}

TEST_F(VolumeFiles, NrrdSpacesMustBeRightHandedAndOfThreeDimensions) {
  const auto content = [](const std::string& field) {
    return std::string(kNrrd) + field + "\nencoding: raw\n\n" + EightBits();
  };
  for (const char* space :
       {"right-anterior-superior", "RAS", "left-posterior-superior", "left posterior superior",
        "lps", "LeftPosteriorSuperior", "scanner-xyz", "3D-right-handed", "3D right handed"}) {
    SCOPED_TRACE(space);
    EXPECT_EQ(Read("a.nrrd", content(fmt::format("space: {}", space))).unused_fields.size(), 0u);
  }
  EXPECT_EQ(Read("a.nrrd", content("space dimension: 3")).unused_fields.size(), 0u);
  for (const char* space : {"left-anterior-superior", "LAS", "left anterior superior",
                            "leftanteriorsuperior", "3D-left-handed", "3Dlefthanded"}) {
    ExpectRefused("a.nrrd", content(fmt::format("space: {}", space)),
                  {"line 7: space is", space, "right-handed", "mirror image"});
  }
  for (const char* space : {"right-anterior-superior-time", "LAST", "right-up", "mine"}) {
    ExpectRefused("a.nrrd", content(fmt::format("space: {}", space)),
                  {"line 7: space is", space, "scanner-xyz or 3D-right-handed"});
  }
  ExpectRefused("a.nrrd", content("space dimension: 4"), {"space dimension is \"4\"; expected 3"});
}

TEST_F(VolumeFiles, NrrdFieldsAreReadInTheirOtherSpellings) {
  const VolumeFile file = Read("a.nrrd", std::string(kNrrd) +
                                             "encoding: raw\nspacedimension: 3\nspacedirections: "
                                             "(1,0,0) (0,2,0) (0,0,.5)\nspaceorigin: (1,2,3)\n\n" +
                                             EightBits());
  EXPECT_EQ(file.volume.spacing, glm::dvec3(1, 2, 0.5));
  EXPECT_EQ(file.volume.origin, glm::dvec3(1, 2, 3));
  EXPECT_EQ(file.unused_fields.size(), 0u);
}

TEST_F(VolumeFiles, NrrdKindsMustBePlacesInSpace) {
  const auto content = [](const std::string& kinds) {
    return std::string(kNrrd) + "kinds: " + kinds + "\nencoding: raw\n\n" + EightBits();
  };
  for (const char* kinds : {"space space space", "Domain domain space", "??? none space"}) {
    EXPECT_EQ(Read("a.nrrd", content(kinds)).unused_fields.size(), 0u);
  }
  for (const char* kinds :
       {"RGB-color domain domain", "complex space space", "space space time",
        "space 3-vector space", "list domain domain", "space space", "space space space space"}) {
    ExpectRefused("a.nrrd", content(kinds), {"line 7: kinds is", kinds, "space, domain or none"});
  }
}

TEST_F(VolumeFiles, ALayoutIsReadWithoutTheSamples) {
  const std::string nrrd =
      "NRRD0004\ntype: ushort\nendian: big\ndimension: 3\nsizes: 1024 1024 1024\nspacings: 1 2 3\n"
      "encoding: raw\n\n";
  const VolumeLayout layout = ReadVolumeLayout(folder_.Write("a.nrrd", nrrd));
  EXPECT_EQ(layout.size, glm::ivec3(1024));
  EXPECT_EQ(layout.type, SampleType::kUint16);
  EXPECT_EQ(layout.spacing, glm::dvec3(1, 2, 3));
  EXPECT_TRUE(layout.big_endian);
  EXPECT_EQ(
      ReadVolumeLayout(folder_.Write("a.mha", std::string(kMeta) + "ElementDataFile = none.raw\n"))
          .size,
      glm::ivec3(2, 3, 2));
  // It refuses the same headers as ReadVolume.
  ExpectError<DataError>(
      [&] {
        ReadVolumeLayout(
            folder_.Write("a.nrrd", "NRRD0004\n" + std::string((size_t{1} << 20) + 9, 'a')));
      },
      {"a.nrrd", "header does not end within"});
  ExpectError<DataError>(
      [&] {
        ReadVolumeLayout(folder_.Write(
            "a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 2 3\nencoding: raw\n\n"));
      },
      {"1 samples along x"});
}

TEST_F(VolumeFiles, NrrdWithSamplesAfterTheHeader) {
  const VolumeFile file =
      Read("a.nrrd", std::string(kNrrd) +
                         "encoding: raw\nspacings: 1 2 0.5\nspace origin: (1, 2,-3e0)\n"
                         "content: words\n\n" +
                         EightBits());
  ExpectEightBits(file.volume);
  EXPECT_EQ(file.volume.spacing, glm::dvec3(1, 2, 0.5));
  EXPECT_EQ(file.volume.origin, glm::dvec3(1, 2, -3));
  EXPECT_EQ(file.unused_fields, std::vector<std::string>{"content"});
  ExpectEightBits(
      Read("b.nrrd", std::string(kNrrd) +
                         "space directions: (1,0,-1e-9) (1e-17,2,0) (0,0,.5)\r\nencoding: "
                         "GZIP\r\n\r\n" +
                         Gzip(EightBits()))
          .volume);
}

TEST_F(VolumeFiles, NrrdTypesInAllSpellings) {
  const auto read = [&](const std::string& type, const std::string& bytes) {
    return Read("a.nrrd", "NRRD0001\ntype: " + type +
                              "\ndimension: 3\nsizes: 2 3 2\nendian: big\nencoding: raw\n\n" +
                              bytes)
        .type;
  };
  for (const char* type : {"uchar", "unsigned char", "uint8", "uint8_t", "Unsigned  Char"}) {
    EXPECT_EQ(read(type, EightBits()), SampleType::kUint8);
  }
  const std::string words = BytesOfValues(std::vector<uint16_t>(12, 7), true);
  for (const char* type :
       {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}) {
    EXPECT_EQ(read(type, words), SampleType::kUint16);
  }
  for (const char* type :
       {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}) {
    EXPECT_EQ(read(type, words), SampleType::kInt16);
  }
  const std::string floats =
      BytesOfValues(std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, true);
  EXPECT_EQ(read("float", floats), SampleType::kFloat32);
}

TEST_F(VolumeFiles, SeparateSamplesMustBeInTheHeadersFolder) {
  folder_.Write("data/s.raw", "head" + EightBits());
  const std::string nrrd = std::string(kNrrd) + "encoding: raw\n";
  ExpectEightBits(Read("a.nhdr", nrrd + "data file: data/s.raw\nbyte skip: 4\n").volume);
  ExpectEightBits(Read("a.nhdr", nrrd + "datafile: ./data/s.raw\nbyteskip: -1\n").volume);
  ExpectEightBits(
      Read("a.mhd", std::string(kMeta) + "HeaderSize = 4\nElementDataFile = data/s.raw\n").volume);
  const VolumeFile file =
      Read("a.mhd", std::string(kMeta) + "HeaderSize = -1\nElementDataFile = data/s.raw\n");
  ExpectEightBits(file.volume);
  EXPECT_EQ(file.data_file, folder_ / "data/s.raw");
  EXPECT_EQ(FilesNamedByVolume(folder_ / "a.mhd"),
            std::vector<std::filesystem::path>{folder_ / "data/s.raw"});
  EXPECT_EQ(FilesNamedByVolume(folder_ / "data/s.raw").size(), 0u);

  for (const char* outside : {"../s.raw", "/etc/passwd", "data/../../s.raw"}) {
    ExpectRefused("a.nhdr", nrrd + "data file: " + outside + "\n",
                  {"a.nhdr, line 8", outside, "inside the header's folder"});
    ExpectRefused("a.mhd", std::string(kMeta) + "ElementDataFile = " + outside + "\n",
                  {"a.mhd, line 5", outside, "inside the header's folder"});
  }
  ExpectRefused("a.nhdr", nrrd + "data file: none.raw\n", {"none.raw"});
  ExpectRefused("a.nhdr", nrrd + "data file: data\n", {"data: is not a file"});
  ExpectRefused("a.nhdr", nrrd + "data file: LIST\n", {"the name of one file"});
  ExpectRefused("a.nhdr", nrrd + "data file: s%03d.raw 1 9 1\n", {"the name of one file"});
  ExpectRefused("a.nhdr", nrrd + "data file: data/s.raw\nbyte skip: 99\n",
                {"s.raw", "after its first 99 bytes"});
}

TEST_F(VolumeFiles, NrrdHeadersThatAreRefused) {
  const auto header = [](const std::string& type, const std::string& rest) {
    return "NRRD0004\ntype: " + type + "\ndimension: 3\nsizes: 2 3 2\n" + rest + "\n\n" +
           EightBits();
  };
  const std::string raw = "encoding: raw";
  ExpectRefused("a.nrrd", "PNG", {"a.nrrd", "NRRD0001 to NRRD0005"});
  ExpectRefused("a.nrrd", "", {"NRRD0001 to NRRD0005"});
  ExpectRefused("a.nrrd", "NRRD0009\n", {"NRRD0001 to NRRD0005"});
  ExpectRefused("a.nrrd", "NRRD0004\nwords\n", {"line 2: is not a field (name: value)"});
  ExpectRefused("a.nrrd", "NRRD0004\n", {"dimension is missing"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 4\n", {"line 2: dimension is \"4\"; expected 3"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\n", {"sizes is missing"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 1 2\n", {"three sample counts"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 2 3 2.5\n", {"three sample counts"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 2 3 99999999999\n",
                {"three sample counts"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\ndimension: 3\n",
                {"line 3: dimension is given twice"});
  ExpectRefused("a.nrrd", "NRRD0004\ndimension: 3\nsizes: 2 3 2\n", {"type is missing"});
  ExpectRefused("a.nrrd", header("double", raw),
                {"line 2: type is \"double\"", "uint8, uint16, int16 or float; convert"});
  ExpectRefused("a.nrrd", header("uchar", "content: words"), {"encoding is missing"});
  ExpectRefused("a.nrrd", header("uchar", "encoding: bzip2"), {"\"bzip2\"; expected raw or gzip"});
  ExpectRefused("a.nrrd", header("ushort", raw), {"endian is missing"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nendian: middle"), {"little or big"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nline skip: 2"),
                {"line skip is \"2\"", "byte skip"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nbyte skip: -2"), {"byte skip is \"-2\""});
  ExpectRefused("a.nrrd", header("uchar", "encoding: gzip\nbyte skip: -1"),
                {"byte skip is \"-1\""});
  ExpectRefused("a.nrrd", header("uchar", "encoding: gzip\nbyte skip: 1"),
                {"0 if the encoding is gzip"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspacings: 1 nan 1"),
                {"spacings", "three numbers"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspacings: 1 0 1"), {"a spacing of 0 along y"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace directions: (0,1,0) (1,0,0) (0,0,1)"),
                {"space directions", "rotated, sheared or mirrored"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace directions: (-1,0,0) (0,1,0) (0,0,1)"),
                {"rotated, sheared or mirrored"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace directions: (1,0,0) (0,1,0)"),
                {"vectors like"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace directions: (1,0) (0,1)"),
                {"vectors like"});
  ExpectRefused("a.nrrd",
                header("uchar", raw + "\nspace directions: (1,0,0) (0,1,0) (0,0,1) (1,1,1)"),
                {"three vectors"});
  ExpectRefused(
      "a.nrrd",
      header("uchar", raw + "\nspacings: 1 1 1\nspace directions: (1,0,0) (0,1,0) (0,0,1)"),
      {"either this or spacings"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace origin: (1,2)"), {"space origin"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace origin: (1,2,3) 4"), {"one vector"});
  ExpectRefused("a.nrrd", header("uchar", raw + "\nspace origin: (1e99,2,3)"),
                {"an origin of 1e+99"});
  ExpectRefused("a.nrrd", "NRRD0004\n" + std::string((size_t{1} << 20) + 9, 'a'),
                {"header does not end within"});
}

TEST_F(VolumeFiles, ASmallFileThatClaimsManySamplesCostsNothing) {
  const std::string claim =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1024 1024 1024\nencoding: ";
  ExpectRefused("a.nrrd", claim + "raw\n\nabc", {"contains 3 bytes", "1,073,741,824"});
  ExpectRefused("a.nrrd", claim + "gzip\n\nabc", {"3 bytes of compressed samples cannot hold"});
}

TEST_F(VolumeFiles, DamagedCompressedSamplesAreRefused) {
  std::string packed = Gzip(EightBits());
  const std::string header = std::string(kNrrd) + "encoding: gzip\n\n";
  ExpectRefused("a.nrrd", header + packed.substr(0, packed.size() / 2), {"damaged or end after"});
  packed[12] = char(~packed[12]);
  ExpectRefused("a.nrrd", header + packed, {"damaged or end after"});
}

TEST_F(VolumeFiles, MetaImageWithSamplesAfterTheHeader) {
  const VolumeFile file =
      Read("a.mha",
           std::string(kMeta) +
               "BinaryData = True\nElementSpacing = 1 2 0.5\nOffset = 4 5 6\nTransformMatrix = 1 "
               "0 0 0 1 0 0 0 1\nAnatomicalOrientation = RAI\nElementDataFile = LOCAL\n" +
               EightBits());
  ExpectEightBits(file.volume);
  EXPECT_EQ(file.volume.spacing, glm::dvec3(1, 2, 0.5));
  EXPECT_EQ(file.volume.origin, glm::dvec3(4, 5, 6));
  EXPECT_EQ(file.unused_fields, std::vector<std::string>{"AnatomicalOrientation"});
  ExpectEightBits(Read("b.mha", std::string(kMeta) +
                                    "CompressedData = True\nCompressedDataSize = 30\n"
                                    "ElementDataFile = LOCAL\n" +
                                    Gzip(EightBits()))
                      .volume);
}

TEST_F(VolumeFiles, MetaImageTypesAndByteOrders) {
  for (const bool big : {false, true}) {
    for (const char* order : {"ElementByteOrderMSB", "BinaryDataByteOrderMSB"}) {
      const VolumeFile file = Read(
          "a.mha", fmt::format("NDims = 3\nDimSize = 2 2 2\nElementType = MET_USHORT\n{} = {}\n"
                               "ElementDataFile = LOCAL\n",
                               order, big ? "True" : "False") +
                       BytesOfValues(std::vector<uint16_t>(8, 513), big));
      EXPECT_FLOAT_EQ(file.volume.samples[7], 513.0f / 65535);
    }
  }
  EXPECT_EQ(Read("a.mha",
                 "NDims = 3\nDimSize = 2 2 2\nElementType = MET_FLOAT\nElementDataFile = "
                 "LOCAL\n" +
                     BytesOfValues(std::vector<float>{0, 1, 2, 3, 4, 5, 6, 8}, false))
                .volume.samples[4],
            0.5f);
}

TEST_F(VolumeFiles, MetaImageHeadersThatAreRefused) {
  const auto header = [](const std::string& rest) {
    return kMeta + rest + "\nElementDataFile = LOCAL\n" + EightBits();
  };
  ExpectRefused("a.mha", "words\n", {"a.mha, line 1: is not a field (Name = value)"});
  ExpectRefused("a.mha", "", {"NDims is missing"});
  ExpectRefused("a.mha", "ObjectType = Tube\n", {"ObjectType is \"Tube\""});
  ExpectRefused("a.mha", "NDims = 2\n", {"NDims is \"2\"; expected 3"});
  ExpectRefused("a.mha", "NDims = 3\nElementType = MET_UCHAR\n", {"DimSize is missing"});
  ExpectRefused("a.mha", "NDims = 3\nDimSize = 2 2 2\n", {"ElementType is missing"});
  ExpectRefused("a.mha", "NDims = 3\nDimSize = 2 2 2\nElementType = MET_LONG\n",
                {"MET_UCHAR, MET_USHORT, MET_SHORT or"});
  ExpectRefused("a.mha", kMeta, {"ElementDataFile is missing"});
  ExpectRefused("a.mha", header("NDims = 3"), {"line 5: NDims is given twice"});
  ExpectRefused("a.mha", header("ElementNumberOfChannels = 3"),
                {"ElementNumberOfChannels is \"3\""});
  ExpectRefused("a.mha", header("BinaryData = False"), {"samples as text"});
  ExpectRefused("a.mha", header("BinaryData = Maybe"), {"True or False"});
  ExpectRefused("a.mha", header("HeaderSize = -2"), {"HeaderSize is \"-2\""});
  ExpectRefused("a.mha", header("CompressedData = True\nHeaderSize = -1"),
                {"HeaderSize is \"-1\""});
  ExpectRefused("a.mha", header("TransformMatrix = 0 1 0 1 0 0 0 0 1"), {"rotated axes"});
  ExpectRefused("a.mha", header("TransformMatrix = 1 0 0 1"), {"nine numbers"});
  ExpectRefused("a.mha", header("ElementSpacing = 1 1"), {"three numbers"});
  ExpectRefused("a.mha", header("ElementSpacing = 1 -1 1"), {"a spacing of -1 along y"});
  ExpectRefused("a.mha", header("Offset = a b c"), {"Offset is \"a b c\""});
  ExpectRefused("a.mha", std::string(kMeta) + "ElementDataFile = LIST\n", {"one file"});
  ExpectRefused("a.mha", std::string(kMeta) + "ElementDataFile = LOCAL\nabc", {"contains 3 bytes"});
}

TEST(IsVolumeFile, GoesByTheExtension) {
  for (const char* name : {"a.raw", "a.NRRD", "a.nhdr", "b/a.mha", "a.mhd"}) {
    EXPECT_TRUE(IsVolumeFile(name));
  }
  for (const char* name : {"a", "a.png", "raw", "/tmp"}) EXPECT_FALSE(IsVolumeFile(name));
}

}  // namespace
}  // namespace tetrec
