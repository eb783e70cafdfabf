#include "run/left_out_photos.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(LeftOutPhotos, AreReadAsTheyWereWritten) {
  const ScratchFolder folder;
  const std::vector<std::string> names = {"a.jpg", "b/c.jpg"};
  WriteLeftOutPhotos(folder / kLeftOutPhotosFile, names);
  EXPECT_EQ(ReadLeftOutPhotos(folder / kLeftOutPhotosFile), names);
}

TEST(LeftOutPhotos, AreRefusedIfOneIsNamedTwice) {
  const ScratchFolder folder;
  ExpectError<DataError>(
      [&] {
        WriteLeftOutPhotos(folder / "twice.json", {"a.jpg", "a.jpg"});
      },
      {"twice.json", "a.jpg"});
  folder.Write("other.json", R"({"schema": 2, "views": []})");
  ExpectError<DataError>([&] { ReadLeftOutPhotos(folder / "other.json"); },
                         {"other.json", "schema", "run tetrec-optimize again"});
}

}  // namespace
}  // namespace tetrec
