// Walks through folders: links, circles, folders that may not be listed.
#include "core/folder_files.h"

#include "core/error.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using ::testing::UnorderedElementsAre;

std::vector<std::string> Names(const fs::path& folder,
                               const std::function<bool(const fs::path&)>& enters = {}) {
  std::vector<std::string> names;
  for (const fs::path& file : FilesBelow(folder, enters)) {
    names.push_back(file.lexically_relative(folder).string());
  }
  return names;
}

TEST(FolderFiles, FollowsLinksToFoldersOnceAndListsBrokenOnes) {
  const ScratchFolder scratch;
  scratch.Write("elsewhere/b.jpg", "b");
  scratch.Write("photos/a.jpg", "a");
  const fs::path photos = scratch / "photos";
  fs::create_directory_symlink("../elsewhere", photos / "day2");
  fs::create_directory_symlink("..", scratch / "elsewhere/circle");
  fs::create_symlink("missing.jpg", photos / "broken.jpg");
  scratch.Write("photos/z/c.jpg", "c");
  fs::create_directory_symlink("z", photos / "also_z");
  EXPECT_THAT(Names(photos), UnorderedElementsAre("a.jpg", "broken.jpg", "day2/b.jpg", "z/c.jpg"));
  EXPECT_THAT(Names(photos, [](const fs::path& path) { return path.filename() != "day2"; }),
              UnorderedElementsAre("a.jpg", "broken.jpg", "z/c.jpg"));
  ExpectError<DataError>([&] { FilesBelow(scratch / "none"); },
                         {scratch / "none", "cannot be listed"});
}

TEST(FolderFiles, NamesTheFolderThatMayNotBeListed) {
  const ScratchFolder scratch;
  scratch.Write("photos/locked/a.jpg", "a");
  if (geteuid() == 0) GTEST_SKIP() << "root may list every folder";
  const fs::path locked = scratch / "photos/locked";
  fs::permissions(locked, fs::perms::none);
  ExpectError<EnvironmentError>([&] { FilesBelow(scratch / "photos"); },
                                {locked.string(), "make it readable"});
  fs::permissions(locked, fs::perms::owner_all);
}

}  // namespace
}  // namespace tetrec
