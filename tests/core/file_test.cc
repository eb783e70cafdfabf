// Files: bounded reading, writing by rename, JSON, hashes, byte readers.
#include "core/file.h"

#include "core/error.h"
#include "core/message_of.h"
#include "file_size_limit.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace tetrec {
namespace {

using ::testing::HasSubstr;

std::vector<uint8_t> BytesOf(const std::string& text) { return {text.begin(), text.end()}; }

TEST(File, WhatIsWrittenIsReadAgain) {
  const ScratchFolder folder;
  std::string text;
  for (int i = 0; i < 70000; ++i) text += char(i);
  WriteText(folder / "a", text);
  EXPECT_EQ(ReadText(folder / "a"), text);
  EXPECT_EQ(ReadBytes(folder / "a"), BytesOf(text));
  WriteText(folder / "a", "");
  EXPECT_EQ(ReadText(folder / "a"), "");
}

TEST(File, WritingLeavesNothingBesideTheFile) {
  const ScratchFolder folder;
  WriteText(folder / "a", "one");
  WriteText(folder / "a", "two");
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    files += entry.is_regular_file();
  EXPECT_EQ(files, 1u);
}

TEST(File, MissingFilesFoldersAndTooLargeFilesAreNamed) {
  const ScratchFolder folder;
  WriteText(folder / "large", "0123456789");
  EXPECT_THAT(MessageOf<DataError>([&] { ReadBytes(folder / "none"); }),
              HasSubstr("none: cannot be read (No such file"));
  EXPECT_THAT(MessageOf<DataError>([&] { ReadBytes(folder.path()); }), HasSubstr("is not a file"));
  EXPECT_THAT(MessageOf<DataError>([&] { ReadBytes(folder / "large", 9); }),
              HasSubstr("large: has 10 bytes; at most 9 are read"));
  EXPECT_THAT(MessageOf<EnvironmentError>([&] { WriteText(folder / "none/x", "12345"); }),
              HasSubstr("5 bytes"));
}

// Without O_NONBLOCK the opening of a pipe would wait for ever.
TEST(File, PipesAndDevicesAreRefusedAtOnce) {
  const ScratchFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder / "zero");
  for (const char* name : {"pipe", "zero"}) {
    const std::filesystem::path file = folder / name;
    EXPECT_THAT(MessageOf<DataError>([&] { ReadBytes(file); }), HasSubstr("is not a file"));
    EXPECT_THAT(MessageOf<DataError>([&] { ReadText(file); }), HasSubstr("is not a file"));
    EXPECT_THAT(MessageOf<DataError>([&] { ReadFront(file, 9); }), HasSubstr("is not a file"));
    EXPECT_THAT(MessageOf<DataError>([&] { Sha256OfFile(file); }), HasSubstr("is not a file"));
  }
}

TEST(File, LinksAndSecondNamesAreReplacedAndNotWrittenTo) {
  const ScratchFolder folder;
  WriteText(folder / "victim", "mine");
  for (const char* name : {"a", "a.tmp"}) {
    std::filesystem::create_symlink("victim", folder / name);
    WriteText(folder / "a", "new");
    EXPECT_EQ(ReadText(folder / "victim"), "mine") << name;
    EXPECT_EQ(ReadText(folder / "a"), "new");
    EXPECT_FALSE(std::filesystem::is_symlink(folder / "a"));
    std::filesystem::remove(folder / "a");
    std::filesystem::create_hard_link(folder / "victim", folder / name);
    WriteText(folder / "a", "new");
    EXPECT_EQ(ReadText(folder / "victim"), "mine") << name;
    std::filesystem::remove(folder / "a");
  }
}

TEST(File, DeeplyNestedJsonIsRefused) {
  const auto nested = [](const std::string& open, const std::string& inner, size_t depth) {
    std::string text;
    for (size_t i = 0; i < depth; ++i) text += open;
    return text + inner;
  };
  for (const char* open : {"[", "{\"a\":"}) {
    for (const size_t depth : {101, 5000, 200000}) {
      EXPECT_THAT(MessageOf<DataError>([&] { ParseJson(nested(open, "", depth), "x.json"); }),
                  HasSubstr("x.json: is not valid JSON: "));
    }
  }
  EXPECT_NO_THROW(ParseJson(nested("[", "", 100) + std::string(100, ']'), "x.json"));
  EXPECT_NO_THROW(ParseJson("\"" + nested("[{\\\"", "", 1000) + "\"", "x.json"));
}

// The kernel reports sizes of some of its own files that exceed their content.
TEST(File, ThatEndsBeforeItsSizeIsRefused) {
  const std::filesystem::path file = "/sys/devices/system/cpu/online";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "there is no " << file;
  EXPECT_THAT(MessageOf<DataError>([&] { ReadBytes(file); }),
              HasSubstr(file.string() + ": ends at byte "));
}

// The memory of this process, which has nothing mapped at its start.
TEST(File, ThatCannotBeReadThoughItOpensIsNamed) {
  EXPECT_THAT(MessageOf<DataError>([] { Sha256OfFile("/proc/self/mem"); }),
              HasSubstr("/proc/self/mem: cannot be read (Input/output error)"));
}

TEST(File, AFailedWriteKeepsTheOldFileAndStatesWhy) {
  const ScratchFolder folder;
  WriteText(folder / "a", "old");
  const std::string message = MessageOf<EnvironmentError>([&] {
    const FileSizeLimit limit(4096);
    WriteText(folder / "a", std::string(100000, 'x'));
  });
  EXPECT_THAT(message, HasSubstr("100,000 bytes"));
  EXPECT_EQ(ReadText(folder / "a"), "old");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.tmp"));
}

TEST(FileWriter, PiecesMakeOneFileAndWithoutFinishNothingIsLeft) {
  const ScratchFolder folder;
  WriteText(folder / "a", "old");
  const auto write = [&](bool finish) {
    FileWriter writer(folder / "a", 10);
    writer.WriteArray(std::span<const char>("ab", 2));
    writer.WriteArray(std::span<const uint32_t>(std::vector<uint32_t>{0x64636261, 0x68676665}));
    EXPECT_EQ(ReadText(folder / "a"), "old");
    if (finish) writer.Finish();
  };
  write(false);
  EXPECT_EQ(ReadText(folder / "a"), "old");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.tmp"));
  write(true);
  EXPECT_EQ(ReadText(folder / "a"), "ababcdefgh");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.tmp"));
}

TEST(FileWriter, ACountOtherThanTheAnnouncedOneIsABug) {
  const ScratchFolder folder;
  FileWriter writer(folder / "a", 3);
  writer.WriteArray(std::span<const char>("ab", 2));
  EXPECT_THAT(MessageOf<BugError>([&] { writer.Finish(); }), HasSubstr("2 of 3 bytes"));
}

TEST(File, TheFrontOfAFileIsReadWithoutTheRest) {
  const ScratchFolder folder;
  WriteText(folder / "a", "0123456789");
  EXPECT_EQ(ReadFront(folder / "a", 4), BytesOf("0123"));
  EXPECT_EQ(ReadFront(folder / "a", 40), BytesOf("0123456789"));
  EXPECT_THAT(MessageOf<DataError>([&] { ReadFront(folder / "none", 4); }), HasSubstr("none"));
}

TEST(File, JsonKeepsValuesAndErrorsGiveThePosition) {
  const ScratchFolder folder;
  const nlohmann::json value = {{"a", 1}, {"b", {0.1, "x"}}};
  WriteJson(folder / "a.json", value);
  EXPECT_EQ(ReadJson(folder / "a.json"), value);
  WriteText(folder / "b.json", "{\"a\": 1,\n  oops}");
  const std::string message = MessageOf<DataError>([&] { ReadJson(folder / "b.json"); });
  EXPECT_THAT(message, HasSubstr("b.json: is not valid JSON: "));
  EXPECT_THAT(message, HasSubstr("line 2"));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(File, JsonNumbersTooLargeForADoubleAreErrors) {
  const ScratchFolder folder;
  WriteText(folder / "a.json", "{\"a\": 1e999}");
  EXPECT_THAT(MessageOf<DataError>([&] { ReadJson(folder / "a.json"); }),
              HasSubstr("a.json: is not valid JSON: number overflow"));
}

TEST(File, FileNamesThatAreNotUtf8CanBeWrittenAsJson) {
  const ScratchFolder folder;
  WriteJson(folder / "a.json", {{"name", "\xff.jpg"}});
  EXPECT_TRUE(ReadJson(folder / "a.json").contains("name"));
}

// The digests of FIPS 180-2, appendix B, and of the empty message.
TEST(File, Sha256GivesThePublishedDigests) {
  EXPECT_EQ(Sha256(BytesOf("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256(BytesOf("")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const ScratchFolder folder;
  WriteText(folder / "million", std::string(1000000, 'a'));
  EXPECT_EQ(Sha256OfFile(folder / "million"),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(ByteReader, ReadsBackWhatByteWriterWrote) {
  ByteWriter writer;
  writer.Write(uint32_t{7});
  writer.Write(2.5);
  const std::vector<float> floats = {1, 2, 3};
  writer.WriteArray(std::span<const float>(floats));
  ByteReader reader(writer.bytes(), "x");
  EXPECT_EQ(reader.Read<uint32_t>("a"), 7u);
  EXPECT_EQ(reader.Read<double>("b"), 2.5);
  EXPECT_EQ(reader.ReadArray<float>(3, "c"), floats);
  EXPECT_NO_THROW(reader.ExpectEnd());
}

TEST(ByteReader, NamesTheByteWhereDataEndsOrIsLeftOver) {
  const std::vector<uint8_t> bytes(6);
  ByteReader reader(bytes, "file.bin");
  reader.Read<uint32_t>("head");
  EXPECT_EQ(MessageOf<DataError>([&] { reader.Read<uint32_t>("tail"); }),
            "file.bin: ends at byte 6 where tail was expected");
  EXPECT_THAT(MessageOf<DataError>([&] { reader.ExpectEnd(); }),
              HasSubstr("2 bytes are left over"));
}

TEST(ByteReader, RefusesCountsThatDoNotFitBeforeTakingMemory) {
  const std::vector<uint8_t> bytes(64);
  for (const uint64_t count : {uint64_t{17}, uint64_t{1} << 62, ~uint64_t{0}}) {
    ByteReader reader(bytes, "file.bin");
    EXPECT_THAT(MessageOf<DataError>([&] { reader.ReadArray<float>(count, "things"); }),
                HasSubstr("do not fit"));
  }
}

}  // namespace
}  // namespace tetrec
