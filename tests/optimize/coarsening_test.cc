#include "optimize/coarsening.h"

#include "core/stop_request.h"
#include "optimize/small_run.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>
#include <sys/time.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <vector>

namespace tetrec {
namespace {

// A run whose single round has been done.
struct GrownRun {
  explicit GrownRun(const OptimizeOptions& options = SmallRunOptions()) : run(options) {
    rounds.Resume({.rounds = 1});
    run.steps.Resume(1000, 0);
  }

  const ScratchFolder folder;
  SmallRun run;
  RefinedParts parts{run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer};
  RefinementRounds rounds{
      run.options, {{0.1, 1000}}, parts, {folder / "best.bin", folder / "unrefined.bin"}};
  Coarsening coarsening{run.options, parts, rounds, folder / "finer.bin", folder / "coarser.bin"};
};

TEST(Coarsening, KeepsACoarserMeshWhoseJudgingPicturesAreMatched) {
  GrownRun grown;
  const size_t vertices = grown.run.field.mesh().positions.size();
  ASSERT_TRUE(grown.coarsening.IsDue(0.6));
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  EXPECT_EQ(grown.run.field.mesh().positions.size(), vertices);
  EXPECT_FALSE(grown.coarsening.state().reference.empty());
  grown.run.options.schedule.matched_psnr = 1;
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  const TetMesh& mesh = grown.run.field.mesh();
  CheckTetMesh(mesh);
  EXPECT_LT(mesh.positions.size(), vertices);
  EXPECT_EQ(grown.coarsening.state().kept_share, 0.25);
  const GrowthStep& step = grown.rounds.state().steps.back();
  EXPECT_EQ(step.decision, GrowthDecision::kCoarsen);
  EXPECT_EQ(step.tets, mesh.tets.size());
  EXPECT_GT(step.psnr, 0.0);
}

// Nothing is as good as a reference without errors.
TEST(Coarsening, TakesBackACoarserMeshThatLost) {
  GrownRun grown;
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  CoarseningState state = grown.coarsening.state();
  for (ErrorSum& view : state.reference) view.squares *= 1e-6;
  grown.coarsening.Resume(state);
  const std::vector<glm::vec3> positions = grown.run.field.mesh().positions;
  const FieldState before = grown.run.field.ReadState();
  const uint64_t iteration = grown.run.steps.iteration();
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  EXPECT_TRUE(grown.run.field.mesh().positions == positions);
  EXPECT_TRUE(grown.run.field.ReadState().parameters == before.parameters);
  EXPECT_EQ(grown.run.steps.iteration(), iteration);
  EXPECT_EQ(grown.rounds.state().steps.back().decision, GrowthDecision::kTooCoarse);
  EXPECT_LT(grown.rounds.state().steps.back().vertices, positions.size());
  EXPECT_EQ(grown.coarsening.state().kept_share, std::sqrt(0.5));
  EXPECT_TRUE(grown.coarsening.IsOver());
}

// After `delay_us` microseconds; at once if it is 0.
void StopLater(int delay_us) {
  if (delay_us == 0) std::raise(SIGINT);
  std::signal(SIGALRM, [](int) { std::raise(SIGINT); });
  const itimerval once = {{0, 0}, {0, delay_us}};
  setitimer(ITIMER_REAL, &once, nullptr);
}

// Of the first look, of a trial whose mesh would stay, and of one that it may lose: each is undone,
// or has ended before.
TEST(Coarsening, IsUndoneByAStop) {
  const auto stopped = [](int kind, int delay_us) {
    CatchStopSignals();
    GrownRun grown;
    if (kind > 0) grown.coarsening.Advance(0.0, AtProgress(0.6));
    grown.run.options.schedule.matched_psnr = kind == 1 ? 1 : 1000;
    const CoarseningState state = grown.coarsening.state();
    const std::vector<glm::vec3> positions = grown.run.field.mesh().positions;
    const std::vector<float> parameters = grown.run.field.ReadState().parameters;
    const uint64_t iteration = grown.run.steps.iteration(), rays = grown.run.steps.rays();
    StopLater(delay_us);
    const bool is_coarser = grown.coarsening.Advance(0.0, AtProgress(0.6));
    const bool has_ended = grown.coarsening.state() != state;
    const bool is_as_before = !is_coarser && grown.run.field.mesh().positions == positions &&
                              grown.run.field.ReadState().parameters == parameters &&
                              grown.run.steps.iteration() == iteration &&
                              grown.run.steps.rays() == rays &&
                              grown.rounds.state().steps.empty() && grown.coarsening.IsDue(0.6);
    std::exit(is_as_before || (has_ended && delay_us > 0) ? 0 : 1);
  };
  for (const int kind : {0, 1, 2}) {
    for (const int delay_us : {0, 2'000, 20'000, 100'000}) {
      EXPECT_EXIT(stopped(kind, delay_us), ::testing::ExitedWithCode(0), "") << kind << delay_us;
    }
  }
}

TEST(Coarsening, TriesMilderSharesAsLongAsTheyMaySucceed) {
  EXPECT_FALSE(IsExpectedToFail({.gain = -0.3, .standard_error = 0.2}, 0.5, 0.75));
  EXPECT_TRUE(IsExpectedToFail({.gain = -0.5, .standard_error = 0.2}, 0.5, 0.75));
  EXPECT_FALSE(IsExpectedToFail({.gain = -0.5, .standard_error = 0.2}, 0.5, 0.9));
}

TEST(Coarsening, TriesMilderSharesWherePicturesThatAreMoreThanMatchedMayLose) {
  for (const bool may_lose : {true, false}) {
    GrownRun grown;
    grown.coarsening.Advance(0.0, AtProgress(0.6));
    CoarseningState state = grown.coarsening.state();
    for (ErrorSum& view : state.reference) view.squares *= 1e-6;
    grown.coarsening.Resume(state);
    grown.run.options.schedule.matched_psnr = may_lose ? 50 : 1000;
    grown.coarsening.Advance(0.0, AtProgress(0.6));
    EXPECT_EQ(grown.rounds.state().steps.back().decision, GrowthDecision::kTooCoarse);
    EXPECT_EQ(grown.coarsening.IsOver(), !may_lose);
  }
}

TEST(Coarsening, KeepsASixteenthOrMoreInOneTrial) {
  GrownRun grown;
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  CoarseningState state = grown.coarsening.state();
  state.kept_share = 0.2;
  grown.coarsening.Resume(state);
  grown.run.options.schedule.matched_psnr = 1;
  ASSERT_TRUE(grown.coarsening.Advance(0.0, AtProgress(0.6)));
  EXPECT_EQ(grown.coarsening.state().kept_share, 1.0 / 16);
}

// Almost anything is as good as a reference with large errors, but the finer mesh is better, too.
TEST(Coarsening, LetsTheFinerMeshLearnAsMuchBeforeACoarserOneReplacesIt) {
  GrownRun grown;
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  CoarseningState state = grown.coarsening.state();
  for (ErrorSum& view : state.reference) view.squares *= 1e6;
  grown.coarsening.Resume(state);
  const std::vector<glm::vec3> positions = grown.run.field.mesh().positions;
  const uint64_t iteration = grown.run.steps.iteration();
  grown.coarsening.Advance(0.0, AtProgress(0.6));
  EXPECT_EQ(grown.run.field.mesh().positions.size(), positions.size());
  EXPECT_GT(grown.run.steps.iteration(), iteration);
  EXPECT_EQ(grown.rounds.state().steps.back().decision, GrowthDecision::kTooCoarse);
  EXPECT_GT(GainBetween(state.reference, grown.coarsening.state().reference).gain, 10.0);
}

TEST(Coarsening, WaitsUntilTheRoundsAreOverAndWhatTheyInsertedIsLearned) {
  GrownRun grown;
  grown.rounds.Resume({});
  EXPECT_FALSE(grown.coarsening.IsDue(0.6));
  grown.rounds.Resume({.rounds = 1, .steps = {{.iteration = 990}}});
  EXPECT_FALSE(grown.coarsening.IsDue(0.6));
  grown.rounds.Resume({.rounds = 1, .steps = {{.iteration = 950}}});
  EXPECT_TRUE(grown.coarsening.IsDue(0.6));
  EXPECT_FALSE(grown.coarsening.IsDue(0.69));  // it would end too late
  grown.run.pictures.PlaceCameras({}, 0.9);
  EXPECT_FALSE(grown.coarsening.IsDue(0.6));
}

// What was known before the last two rounds of a mesh that grew and gained.
std::vector<GrowthStep> GainedSteps() {
  return {{.vertices = 900, .psnr = 29.5, .decision = GrowthDecision::kRefine},
          {.vertices = 1000,
           .psnr = 30,
           .gain = 0.5,
           .gain_standard_error = 0.1,
           .decision = GrowthDecision::kRefine}};
}

TEST(Coarsening, SeesWhetherTheLastRoundsStillGained) {
  const auto still_gains = [](auto change) {
    std::vector<GrowthStep> steps = GainedSteps();
    change(steps);
    return StillGains({.steps = steps}, 40);
  };
  EXPECT_TRUE(still_gains([](auto&) {}));
  EXPECT_FALSE(still_gains([](auto& steps) { steps.back().gain_standard_error = 0.3; }));
  EXPECT_FALSE(still_gains([](auto& steps) { steps.back().psnr = 36; }));
  EXPECT_FALSE(still_gains([](auto& steps) { steps.front().vertices = 1000; }));
  EXPECT_FALSE(
      still_gains([](auto& steps) { steps.back().decision = GrowthDecision::kFineEnough; }));
  EXPECT_FALSE(still_gains([](auto& steps) { steps.erase(steps.begin()); }));
  EXPECT_FALSE(still_gains([](auto& steps) { steps.clear(); }));
}

TEST(Coarsening, MakesNoTrialInAShortRunWhoseMeshStillGains) {
  for (const uint64_t iterations : {uint64_t{0}, uint64_t{2000}}) {
    OptimizeOptions options = SmallRunOptions();
    options.time_limit_s = 0;
    options.iterations = iterations;
    GrownRun grown(options);
    grown.rounds.Resume({.rounds = 1, .steps = GainedSteps()});
    ASSERT_TRUE(grown.coarsening.IsDue(0.6));
    EXPECT_FALSE(grown.coarsening.Advance(0.0, AtProgress(0.6)));
    EXPECT_EQ(grown.coarsening.IsOver(), iterations > 0) << "without limits there is time";
    EXPECT_EQ(grown.coarsening.state().reference.empty(), iterations > 0);
  }
}

TEST(Coarsening, LeavesMeshesWhoseSizeTheOptionsGive) {
  for (int i = 0; i < 4; ++i) {
    OptimizeOptions options = SmallRunOptions();
    if (i == 0) options.budget = BudgetChoice::kFull;
    if (i == 1) options.schedule.rounds = 1;
    if (i == 2) options.refine = RefineScheme::kBisect;
    if (i == 3) options.judging_pictures = JudgingPictures::kLearned;
    const GrownRun grown(options);
    EXPECT_TRUE(grown.coarsening.IsOver()) << i;
    EXPECT_FALSE(grown.coarsening.IsDue(0.6)) << i;
  }
}

}  // namespace
}  // namespace tetrec
