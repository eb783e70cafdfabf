#include "optimize/stray_photos.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/small_motion.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <numeric>

namespace tetrec {
namespace {

std::vector<ErrorSum> ErrorsOf(const std::vector<double>& squares) {
  std::vector<ErrorSum> errors;
  for (const double square : squares) errors.push_back({512 * square, 512});
  return errors;
}

TEST(FindStray, FindsErrorsFarAboveTheOthers) {
  using Views = std::vector<StrayView>;
  const Views found = FindStray(ErrorsOf({1, 1.1, 0.9, 30, 1, 1.2, 0.8, 1}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].view, 3u);
  EXPECT_NEAR(found[0].error_ratio, 30, 1e-9);
  EXPECT_EQ(FindStray(ErrorsOf({1, 1.1, 0.9, 3.5, 1, 1.2, 0.8, 1})), Views{}) << "not four times";
  EXPECT_EQ(FindStray(ErrorsOf({1, 4, 0.2, 30, 1.5, 8, 0.1, 2})), Views{}) << "all differ";
  EXPECT_EQ(FindStray(ErrorsOf({1, 1, 1, 30, 1, 1, 1})), Views{}) << "too few";
  std::vector<ErrorSum> hidden = ErrorsOf({1, 1, 1, 30, 1, 1, 1, 1, 1, 1});
  hidden[5] = {};               // masks leave nothing of it
  hidden[6] = {32 * 64.0, 64};  // or hardly anything
  ASSERT_EQ(FindStray(hidden).size(), 1u);
  EXPECT_EQ(FindStray(hidden)[0].view, 3u);
}

constexpr size_t kViews = 20;

// The field is the one that the photos show; one camera can be turned to where it was not.
class StrayPhotosTest : public ::testing::Test {
 protected:
  explicit StrayPhotosTest(const OptimizeOptions& options = SmallRunOptions())
      : run_(options, kViews) {
    for (const RenderView& view : run_.pictures.given_views()) {
      poses_.push_back({view.cam_from_world});
    }
    run_.steps.Resume(400, 0);
  }
  void TurnOne() {
    Rigid3& wrong = poses_[2].cam_from_world;
    wrong = MotionOf({0.15, 0.0, 0.0}, glm::dvec3(0.0)) * wrong;
    run_.pictures.PlaceCameras(poses_, 0.25);
  }

  SmallRun run_;
  std::vector<CorrectedPose> poses_;
  StrayPhotos stray_{run_.options, run_.field, run_.pictures, run_.steps};
};

OptimizeOptions WithoutLearning() {
  OptimizeOptions options = SmallRunOptions();
  options.color_rate = options.density_rate = 1e-9;
  return options;
}

class StillStrayPhotosTest : public StrayPhotosTest {
 protected:
  StillStrayPhotosTest() : StrayPhotosTest(WithoutLearning()) {}
};

// And is not tried again while it fits no worse.
TEST_F(StillStrayPhotosTest, APhotoWithoutWhichTheOthersGainNothingStays) {
  TurnOne();
  const size_t blocks = run_.pictures.set().blocks.size();
  const FieldState before = run_.field.ReadState();
  EXPECT_FALSE(stray_.Advance());
  const uint64_t rays = run_.steps.rays();
  EXPECT_GT(rays, 0u) << "a trial";
  EXPECT_EQ(run_.steps.iteration(), 400u);
  EXPECT_EQ(run_.field.ReadState().parameters, before.parameters);
  EXPECT_EQ(stray_.state().left_out, std::vector<uint8_t>(kViews, 0));
  EXPECT_GT(stray_.state().tried_ratio[2], 4.0f);
  EXPECT_EQ(run_.pictures.set().blocks.size(), blocks);
  EXPECT_FALSE(stray_.Advance());
  EXPECT_EQ(run_.steps.rays(), rays) << "no trial";
  StrayState milder = stray_.state();
  milder.tried_ratio[2] *= 0.5f;
  stray_.Resume(milder, "checkpoint.bin");
  EXPECT_FALSE(stray_.Advance());
  EXPECT_GT(run_.steps.rays(), rays) << "it fits worse";
}

TEST_F(StrayPhotosTest, APhotoOfAWrongCameraIsLeftOut) {
  TurnOne();
  ASSERT_FALSE(stray_.IsDue(0.2));
  ASSERT_TRUE(stray_.IsDue(0.25));
  EXPECT_TRUE(stray_.Advance());
  std::vector<uint8_t> expected(kViews, 0);
  expected[2] = 1;
  EXPECT_EQ(stray_.state().left_out, expected);
  EXPECT_FALSE(stray_.IsDue(0.25));
  for (const double progress : {0.3, 1.0}) {  // also once the judging pictures are learned
    run_.pictures.PlaceCameras(poses_, progress);
    for (const RayBlock& block : run_.pictures.set().blocks.List()) EXPECT_NE(block.view, 2u);
  }
}

TEST_F(StrayPhotosTest, AllStayWhereTheCamerasAreRight) {
  EXPECT_FALSE(stray_.Advance());
  EXPECT_EQ(stray_.state().left_out, std::vector<uint8_t>(kViews, 0));
  EXPECT_EQ(run_.steps.rays(), 0u) << "no trial";
}

TEST_F(StrayPhotosTest, APhotoOfACorrectedCameraIsLearnedAgain) {
  StrayState state{1, std::vector<uint8_t>(kViews, 0), std::vector<float>(kViews, 0.0f)};
  state.left_out[4] = 1;
  stray_.Resume(state, "checkpoint.bin");
  run_.pictures.PlaceCameras({}, 0.4);
  EXPECT_TRUE(stray_.Advance());
  EXPECT_EQ(stray_.state().left_out, std::vector<uint8_t>(kViews, 0));
  EXPECT_EQ(run_.pictures.set().blocks.OfView(4).end - run_.pictures.set().blocks.OfView(4).begin,
            run_.pictures.set().blocks.OfView(3).end - run_.pictures.set().blocks.OfView(3).begin);
}

TEST_F(StrayPhotosTest, NothingIsTriedInAShortRunOrOnceAllIsLearned) {
  TurnOne();
  run_.steps.Resume(159, 0);
  EXPECT_FALSE(stray_.Advance());
  EXPECT_EQ(stray_.state().looks, 1u);
  run_.steps.Resume(400, 0);
  run_.pictures.PlaceCameras(poses_, 1.0);
  EXPECT_FALSE(stray_.Advance());
  EXPECT_TRUE(stray_.state().left_out.empty());
}

TEST_F(StrayPhotosTest, ResumeLeavesOutWhatWasLeftOutBefore) {
  StrayState state{1, std::vector<uint8_t>(kViews, 0), std::vector<float>(kViews, 0.0f)};
  state.left_out[4] = 1;
  stray_.Resume(state, "checkpoint.bin");
  for (const RayBlock& block : run_.pictures.set().blocks.List()) EXPECT_NE(block.view, 4u);
  state.left_out.pop_back();
  ExpectError<DataError>([&] { stray_.Resume(state, "checkpoint.bin"); },
                         {"checkpoint.bin: was written for 19 photos, but the scene has 20"});
}

TEST(StrayPhotos, AreLearnedOnRequest) {
  OptimizeOptions options = SmallRunOptions();
  options.stray_photos = StrayChoice::kLearned;
  SmallRun run(options, 10);
  const StrayPhotos stray(run.options, run.field, run.pictures, run.steps);
  EXPECT_FALSE(stray.IsDue(0.9));
}

}  // namespace
}  // namespace tetrec
