// The options of structure from motion.
#include "sfm/options.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/lens.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(SfmOptions, OutOfRangeAreUsageErrorsThatNameThem) {
  const auto expect = [](const std::string& message, auto change) {
    SfmOptions options;
    change(options);
    ExpectError<UsageError>([&] { options.Check(); }, {message});
  };
  EXPECT_NO_THROW(SfmOptions().Check());
  expect("max-size is 0", [](SfmOptions& o) { o.max_size = 0; });
  expect("max-unreadable is 1;", [](SfmOptions& o) { o.max_unreadable = 1; });
  expect("max-unreadable is nan", [](SfmOptions& o) { o.max_unreadable = NAN; });
  expect("frames is 2", [](SfmOptions& o) { o.frames = 2; });
  expect("max-features is -1", [](SfmOptions& o) { o.max_features = -1; });
  expect("holdout is 1", [](SfmOptions& o) { o.holdout = 1; });
  expect("seed is -1", [](SfmOptions& o) { o.seed = -1; });
}

TEST(SfmOptions, OtherWordsAreUnknown) {
  EXPECT_FALSE(FromName<PairChoice>("best"));
  EXPECT_FALSE(FromName<CameraSharing>("all"));
  EXPECT_FALSE(FromName<SfmLens>("FISHEYE"));
}

// COLMAP is given these names.
TEST(SfmOptions, LensesOtherThanAutoAreLensModels) {
  for (const Word<SfmLens>& lens : kWords<SfmLens>) {
    EXPECT_EQ(FromName<LensModel>(lens.word).has_value(), lens.value != SfmLens::kAuto)
        << lens.word;
  }
}

}  // namespace
}  // namespace tetrec
