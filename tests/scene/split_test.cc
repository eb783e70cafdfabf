// The hold-out rule.
#include "scene/split.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

#include <string>

namespace tetrec {
namespace {

std::vector<View> Named(const std::vector<std::string>& names) {
  std::vector<View> views(names.size());
  for (size_t i = 0; i < names.size(); ++i) views[i].name = names[i];
  return views;
}

std::string HeldOutNames(const std::vector<View>& views) {
  std::string names;
  for (const View& view : views) names += view.split == Split::kTest ? view.name : "";
  return names;
}

TEST(HoldOut, TakesTheFirstByNameAndEveryNthAfterIt) {
  std::vector<View> views = Named({"e", "c", "a", "g", "d", "b", "f"});
  HoldOut(views, 3);
  EXPECT_EQ(HeldOutNames(views), "adg");
  EXPECT_EQ(views[1].name, "b");
  EXPECT_EQ(views[1].split, Split::kTrain);
  HoldOut(views, 0);
  EXPECT_EQ(HeldOutNames(views), "");
}

TEST(HoldOut, LeavesAViewToTrainOn) {
  for (const int every : {0, 2, 8, 1000000}) EXPECT_NO_THROW(CheckHoldout(every)) << every;
  for (const int every : {-1, 1, 1000001}) {
    ExpectError<UsageError>([&] { CheckHoldout(every); },
                            {"holdout is " + std::to_string(every), "expected 0", "2 to 1000000"});
  }
}

}  // namespace
}  // namespace tetrec
