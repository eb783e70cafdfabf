// Where the images of a scene folder are stored.
#include "scene/image_files.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <filesystem>
#include <set>

namespace tetrec {
namespace {

using Names = std::vector<std::string>;

TEST(ImageFiles, NamesThatShareAStemKeepTheirExtensions) {
  EXPECT_EQ(ImageFiles({"x/a.jpg", "b.png"}), (Names{"images/x/a.png", "images/b.png"}));
  EXPECT_EQ(ImageFiles({"a.jpg", "a.png", "a.jpg.png"}),
            (Names{"images/a.jpg.png", "images/a.png.png", "images/a.jpg.png.png"}));
}

TEST(ImageFiles, OnlyAnImagesExtensionIsDropped) {
  EXPECT_EQ(ImageFiles({"frame.0000.png", "frame.0001.png"}),
            (Names{"images/frame.0000.png", "images/frame.0001.png"}));
  EXPECT_EQ(ImageFiles({"1700000000.25", "1700000000.5"}),
            (Names{"images/1700000000.25.png", "images/1700000000.5.png"}));
}

TEST(ImageFiles, NamesInSeveralFoldersStayInThem) {
  EXPECT_EQ(ImageFiles({"left/0.jpg", "right/0.jpg", "0.jpg"}),
            (Names{"images/left/0.png", "images/right/0.png", "images/0.png"}));
}

TEST(ImageFiles, NumbersAreUsedIfAFolderHasTheNameOfAFile) {
  EXPECT_EQ(ImageFiles({"a.jpg", "a.png/b.jpg"}),
            (Names{"images/a.jpg.png", "images/a.png/b.jpg.png"}));
  EXPECT_EQ(ImageFiles({"a", "a.png/b.jpg"}), (Names{"images/000000.png", "images/000001.png"}));
}

// Names made of few parts, so that stems and folders often coincide.
rc::Gen<std::string> AnyName() {
  const auto part = rc::gen::element<std::string>("a", "b", "a.png", "a.jpg", ".", "a.0", "a.1",
                                                  "a.png.jpg", "A.PNG");
  return rc::gen::map(rc::gen::pair(part, rc::gen::container<Names>(1, part)),
                      [](const std::pair<std::string, Names>& parts) {
                        return parts.second[0] == "." ? parts.first
                                                      : parts.first + "/" + parts.second[0];
                      });
}

TEST(ImageFiles, DifferentNamesGiveDifferentFilesThatCanAllBeWritten) {
  EXPECT_TRUE(rc::check([] {
    const auto names = *rc::gen::unique<Names>(AnyName());
    const Names files = ImageFiles(names);
    RC_ASSERT(files.size() == names.size());
    std::set<std::string> distinct;
    for (const std::string& file : files) {
      RC_ASSERT(file.starts_with("images/"));
      distinct.insert(std::filesystem::path(file).lexically_normal().generic_string());
    }
    RC_ASSERT(distinct.size() == names.size());
    for (const std::string& file : distinct) {
      for (const std::string& other : distinct) RC_ASSERT(!other.starts_with(file + "/"));
    }
  }));
}

}  // namespace
}  // namespace tetrec
