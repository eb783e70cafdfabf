#include "image/file_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

namespace tetrec {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Flat(const std::vector<std::string>& names) {
  return PngFiles(names, Folders::kFlatten);
}

TEST(FileNames, OnlyTheExtensionOfAnImageIsDropped) {
  EXPECT_EQ(WithoutImageExtension("a/0001.jpg"), "a/0001");
  EXPECT_EQ(WithoutImageExtension("IMG_1.JPG"), "IMG_1");
  EXPECT_EQ(WithoutImageExtension("scan.tif"), "scan");
  EXPECT_EQ(WithoutImageExtension("frame.0001"), "frame.0001");
  EXPECT_EQ(WithoutImageExtension("frame.0001.png"), "frame.0001");
  EXPECT_EQ(WithoutImageExtension("1700000000.25"), "1700000000.25");
  EXPECT_EQ(WithoutImageExtension("a.png/b"), "a.png/b");
  EXPECT_EQ(WithoutImageExtension("a.b/c"), "a.b/c");
  EXPECT_EQ(WithoutImageExtension("a/.png"), "a/.png");
  EXPECT_EQ(WithoutImageExtension("b.exr"), "b");
}

TEST(FileNames, OrdinaryNamesBecomeTheirStems) {
  EXPECT_THAT(Flat({"test/r_0", "test/r_1.png", "0001.jpg"}),
              ElementsAre("test_r_0.png", "test_r_1.png", "0001.png"));
  EXPECT_THAT(Flat({"t/frame.0000.png", "t/frame.0001.png", "12.5", "12.75"}),
              ElementsAre("t_frame.0000.png", "t_frame.0001.png", "12.5.png", "12.75.png"));
  EXPECT_THAT(PngFiles({"test/r_0", "0001.jpg"}, Folders::kKeep),
              ElementsAre("test/r_0.png", "0001.png"));
}

TEST(FileNames, NamesThatWouldCollideKeepTheirExtensionsOrAreNumbered) {
  EXPECT_THAT(Flat({"x.jpg", "x.png", "y.png"}),
              ElementsAre("x.jpg.png", "x.png.png", "y.png.png"));
  EXPECT_THAT(Flat({"a_b", "a/b", "c"}), ElementsAre("000000.png", "000001.png", "000002.png"));
}

TEST(FileNames, NamesThatAFileSystemCannotHaveAreNumbered) {
  const std::string part(200, 'x');
  EXPECT_THAT(PngFiles({part + "/" + part, "b"}, Folders::kKeep),
              ElementsAre(part + "/" + part + ".png", "b.png"));
  EXPECT_THAT(Flat({part + "/" + part, "b"}), ElementsAre("000000.png", "000001.png"));
  EXPECT_THAT(PngFiles({std::string(300, 'x'), "b"}, Folders::kKeep),
              ElementsAre("000000.png", "000001.png"));
}

// Few different parts, so that many names collide.
RC_GTEST_PROP(FileNames, EveryNameHasAFileOfItsOwn, ()) {
  const auto part = rc::gen::elementOf(
      std::vector<std::string>{"a", "b", "_", "/", ".", "000001", ".png", ".JPG", ".0"});
  const auto name = rc::gen::map(rc::gen::container<std::vector<std::string>>(part),
                                 [](const std::vector<std::string>& parts) {
                                   std::string joined;
                                   for (const std::string& p : parts) joined += p;
                                   return joined;
                                 });
  const auto names = *rc::gen::container<std::set<std::string>>(name);
  const std::vector<std::string> files = Flat({names.begin(), names.end()});
  RC_ASSERT(files.size() == names.size());
  RC_ASSERT(std::set<std::string>(files.begin(), files.end()).size() == names.size());
  for (const std::string& file : files) RC_ASSERT(file.find('/') == std::string::npos);
}

}  // namespace
}  // namespace tetrec
