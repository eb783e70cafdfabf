#include "optimize/training_pictures.h"

#include "geometry/small_motion.h"
#include "optimize/exposure.h"
#include "optimize/judging.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

size_t CountNotLearned(const TrainingPictures& pictures) {
  size_t count = 0;
  for (const TargetImage& target : pictures.WithoutJudging()) {
    count += size_t(std::count(target.rgba8.begin(), target.rgba8.end(), kNotJudgedTarget));
  }
  return count;
}

// The squared error of a black field, summed over the pixels that are learned.
double LearnedSquares(SmallRun& run) {
  TrainingBatch batch;
  const std::vector<RayBlock> blocks = run.pictures.set().blocks.List();
  batch.blocks = blocks;
  return run.renderer->Forward(batch).squared_error * double(batch.rays());
}

TEST(TrainingPictures, AreLearnedWholeInTheLastPartOfARun) {
  SmallRun run;
  ASSERT_GT(CountNotLearned(run.pictures), 0u);
  EXPECT_FALSE(run.pictures.learns_all());
  const double squares = LearnedSquares(run);
  const double end = run.options.schedule.last_judging;
  run.pictures.EndJudgingIfDue(end - 0.01);
  EXPECT_FALSE(run.pictures.learns_all());
  EXPECT_EQ(LearnedSquares(run), squares);
  run.pictures.EndJudgingIfDue(end);
  EXPECT_TRUE(run.pictures.learns_all());
  EXPECT_GT(LearnedSquares(run), squares);
}

TEST(TrainingPictures, AreLearnedWholeFromTheStartIfNoneAreKept) {
  OptimizeOptions options = SmallRunOptions();
  options.judging_pictures = JudgingPictures::kLearned;
  EXPECT_TRUE(SmallRun(options).pictures.learns_all());
}

TEST(TrainingPictures, AreLearnedWholeIfNoneOfTheirTilesJudges) {
  int judged = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    OptimizeOptions options = SmallRunOptions();
    options.seed = seed;
    const SmallRun run(options, 1);
    const bool judges = !ChooseJudgingSet(run.pictures.set(), seed).blocks.empty();
    EXPECT_EQ(run.pictures.learns_all(), !judges) << seed;
    judged += judges;
  }
  EXPECT_GT(judged, 0);
  EXPECT_LT(judged, 12);
}

TEST(TrainingPictures, JudgeTheFieldAndAreLearnedAsBefore) {
  SmallRun run;
  const double squares = LearnedSquares(run);
  const double right = run.pictures.JudgeField().psnr;
  EXPECT_EQ(LearnedSquares(run), squares);
  run.PutField(0.0);
  EXPECT_LT(run.pictures.JudgeField().psnr, right - 10);
  EXPECT_FALSE(run.pictures.learns_all());
}

TEST(TrainingPictures, GatherExposuresOfViewsThatNoStepDrawsUntilAllAreLearned) {
  SmallRun run(SmallRunOptions(), kLeastViewsToJudge);
  std::vector<uint8_t> not_drawn = ChooseJudgingSet(run.pictures.set(), run.options.seed).is_whole;
  ASSERT_GT(std::count(not_drawn.begin(), not_drawn.end(), uint8_t{1}), 0);
  std::vector<uint8_t> left_out(kLeastViewsToJudge, 0);
  left_out[3] = not_drawn[3] = 1;
  run.pictures.LeaveOut(left_out);
  const auto gathered = [&run] {
    std::vector<ExposureSums> sums(kLeastViewsToJudge);
    run.pictures.GatherExposuresOfWholeViews(16);
    run.renderer->AddExposureSums(sums);
    return sums;
  };
  std::vector<ExposureSums> sums = gathered();
  for (size_t view = 0; view < sums.size(); ++view) {
    EXPECT_EQ(sums[view][0].ww > 0, not_drawn[view] != 0) << view;
  }
  // The field is right, and so is a neutral exposure.
  const std::vector<ViewExposure> exposures = FitExposures(sums);
  for (const ViewExposure& exposure : exposures) EXPECT_NEAR(exposure.gain.g, 1.0, 0.05);
  run.pictures.EndJudgingIfDue(1.0);
  sums = gathered();
  for (const ExposureSums& of_view : sums) EXPECT_EQ(of_view[0].ww, 0.0);
}

TEST(TrainingPictures, ShowHowWellEachViewFits) {
  SmallRun run(SmallRunOptions(), kLeastViewsToJudge);
  std::vector<CorrectedPose> poses;
  for (const RenderView& view : run.pictures.given_views()) poses.push_back({view.cam_from_world});
  poses[3].cam_from_world =
      MotionOf(glm::dvec3(0.0, 0.3, 0.0), glm::dvec3(0.0)) * poses[3].cam_from_world;
  run.pictures.PlaceCameras(poses, 0.0);
  std::vector<uint8_t> left_out(kLeastViewsToJudge, 0);
  left_out[3] = 1;
  run.pictures.LeaveOut(left_out);
  const std::vector<uint8_t> is_whole =
      ChooseJudgingSet(run.pictures.set(), run.options.seed).is_whole;
  const std::vector<ErrorSum> errors = run.pictures.ErrorsOfViews();
  ASSERT_EQ(errors.size(), kLeastViewsToJudge);
  for (size_t view = 0; view < errors.size(); ++view) {
    EXPECT_EQ(errors[view].rays > 0, is_whole[view] == 0) << view;
    EXPECT_TRUE(view == 3 || 100 * errors[view].squares <= errors[3].squares) << view;
  }
}

TEST(TrainingPictures, TakeCamerasAndGiveThemBack) {
  SmallRun run;
  const std::vector<RenderView> given = run.pictures.given_views();
  std::vector<CorrectedPose> poses;
  for (const RenderView& view : given) {
    poses.push_back({MotionOf(glm::dvec3(0.0, 0.3, 0.0), glm::dvec3(0.0)) * view.cam_from_world});
  }
  const double right = run.pictures.JudgeField().psnr;
  run.pictures.PlaceCameras(poses, 0.1);
  EXPECT_EQ(run.pictures.set().views[1].cam_from_world.rotation, poses[1].cam_from_world.rotation);
  EXPECT_LT(run.pictures.JudgeField().psnr, right - 10);
  run.pictures.PlaceCameras({}, 0.1);
  EXPECT_EQ(run.pictures.JudgeField().psnr, right);
}

}  // namespace
}  // namespace tetrec
