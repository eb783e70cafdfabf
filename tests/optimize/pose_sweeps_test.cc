#include "optimize/pose_sweeps.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/small_motion.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

// The poses that a run with right photos starts from, one of them turned.
PoseState OneTurned(const SmallRun& run) {
  PoseState state;
  for (const RenderView& view : run.pictures.given_views()) {
    state.poses.push_back({view.cam_from_world});
  }
  CorrectedPose& wrong = state.poses[2];
  wrong.cam_from_world = MotionOf({0.02, 0.0, 0.0}, glm::dvec3(0.0)) * wrong.cam_from_world;
  return state;
}

TEST(PoseSweeps, StartWhereCamerasWereEstimatedOrWhenAsked) {
  const auto poses = [](PoseMode mode, bool were_estimated) {
    OptimizeOptions options = SmallRunOptions();
    options.poses = mode;
    SmallRun run(options);
    PoseSweeps sweeps(run.options, run.pictures, *run.renderer);
    sweeps.Start(were_estimated, 0.0);
    return sweeps.state().poses.size();
  };
  EXPECT_EQ(poses(PoseMode::kAuto, false), 0u);
  EXPECT_EQ(poses(PoseMode::kAuto, true), 5u);
  EXPECT_EQ(poses(PoseMode::kOn, false), 5u);
  EXPECT_EQ(poses(PoseMode::kOff, true), 0u);
}

TEST(PoseSweeps, GiveUpWhereTheCamerasAreRight) {
  SmallRun run;
  PoseSweeps sweeps(run.options, run.pictures, *run.renderer);
  sweeps.Start(true, 0.25);
  ASSERT_TRUE(sweeps.IsDue(AtProgress(0.25)));
  EXPECT_EQ(sweeps.Sweep({}, 0.25), 0.0);
  EXPECT_TRUE(sweeps.state().poses.empty());
  EXPECT_FALSE(sweeps.IsDue(AtProgress(0.6)));
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(run.pictures.set().views[i].cam_from_world.translation,
              run.pictures.given_views()[i].cam_from_world.translation);
  }
}

TEST(PoseSweeps, RefuseTheStateOfAnotherScene) {
  SmallRun run;
  PoseSweeps sweeps(run.options, run.pictures, *run.renderer);
  PoseState state = OneTurned(run);
  state.poses.pop_back();
  ExpectError<DataError>([&] { sweeps.Resume(state, "checkpoint.bin", 0.3); },
                         {"checkpoint.bin", "4 cameras, not 5"});
}

TEST(PoseSweeps, GoOnFromAResumedState) {
  SmallRun run;
  PoseSweeps sweeps(run.options, run.pictures, *run.renderer);
  PoseState state = OneTurned(run);
  state.sweeps = 1;
  sweeps.Resume(state, "checkpoint.bin", 0.25);
  EXPECT_EQ(run.pictures.set().views[2].cam_from_world.rotation,
            state.poses[2].cam_from_world.rotation);
  EXPECT_FALSE(sweeps.IsDue(AtProgress(0.22)));
  ASSERT_TRUE(sweeps.IsDue(AtProgress(0.28)));
  const double turned = run.pictures.JudgeField().psnr;
  EXPECT_EQ(sweeps.Sweep({}, 0.28), 0.0);  // the first sweep has decided
  EXPECT_GT(run.pictures.JudgeField().psnr, turned);
  EXPECT_EQ(sweeps.state().sweeps, 2u);
}

}  // namespace
}  // namespace tetrec
