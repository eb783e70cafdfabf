// The quality that COLMAP's model must have.
#include "sfm/model_quality.h"

#include "core/error.h"
#include "expect_error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

ColmapModel ModelOf(size_t images, size_t points, double error_px, size_t track_length) {
  ColmapModel model;
  model.cameras[1] = {LensModel::kPinhole, 1600, 1200, {1000, 1000, 800, 600}};
  for (uint32_t i = 0; i < images; ++i) model.images[i].name = fmt::format("{}.jpg", i);
  for (uint64_t i = 0; i < points; ++i) {
    model.points[i].error_px = error_px;
    model.points[i].track.resize(track_length);
  }
  return model;
}

TEST(JudgeModel, EachLimitIsAppliedAndNamed) {
  std::vector<std::string> names;
  for (int i = 0; i < 50; ++i) names.push_back(fmt::format("{}.jpg", i));
  EXPECT_EQ(JudgeModel(ModelOf(40, 100, 1.5, 3), names).registered, 40u);
  ExpectError<DataError>([&] { JudgeModel(ModelOf(39, 100, 1, 3), names); },
                         {"39 of 50", "39.jpg", "1 more"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 99, 1, 3), names); }, {"99 points"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 100, 1.6, 3), names); }, {"1.60 px"});
  ExpectError<DataError>([&] { JudgeModel(ModelOf(50, 100, 1, 2), names); }, {"2.00 photos"});
  ColmapModel large = ModelOf(50, 100, 1.6, 3);  // the same error in a photo of twice the size
  large.cameras[1].width = 3200;
  EXPECT_NO_THROW(JudgeModel(large, names));
}

TEST(JudgeModel, TheLimitOfTheErrorCanBeReachedInLargePhotos) {
  std::vector<std::string> names;
  for (int i = 0; i < 50; ++i) names.push_back(fmt::format("{}.jpg", i));
  const auto judge = [&](double error_px) {
    ColmapModel model = ModelOf(50, 100, error_px, 3);
    model.cameras[1].width = 8000;
    JudgeModel(model, names);
  };
  EXPECT_NO_THROW(judge(1.9));
  ExpectError<DataError>([&] { judge(2.6); }, {"2.60 px; expected at most 2.50"});
}

}  // namespace
}  // namespace tetrec
