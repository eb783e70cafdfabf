#include "optimize/training_steps.h"

#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

namespace tetrec {
namespace {

TEST(TrainingSteps, ThatWereTriedAreTakenAgainWithTheSameResult) {
  SmallRun run;
  run.PutField(0.2);
  const FieldState before = run.field.ReadState();
  run.steps.Try(3, AtProgress(0.1));
  const FieldState tried = run.field.ReadState();
  EXPECT_TRUE(tried.parameters != before.parameters);
  EXPECT_EQ(run.steps.iteration(), 0u);
  EXPECT_EQ(run.steps.rays(), 3u * 256u);

  run.field.PutState(before);
  for (int i = 0; i < 3; ++i) run.steps.Take(AtProgress(0.1), false);
  EXPECT_TRUE(run.field.ReadState().parameters == tried.parameters);
  EXPECT_TRUE(run.field.ReadState().second_moment == tried.second_moment);
  EXPECT_EQ(run.steps.iteration(), 3u);
}

TEST(TrainingSteps, AfterAResumeAreThoseThatWouldHaveFollowed) {
  SmallRun whole, resumed;
  whole.PutField(0.2);
  whole.steps.Take(AtProgress(0.1), false);
  whole.steps.Take(AtProgress(0.1), false);
  resumed.field.PutState(whole.field.ReadState());
  resumed.steps.Resume(whole.steps.iteration(), whole.steps.rays());
  for (SmallRun* run : {&whole, &resumed}) run->steps.Take(AtProgress(0.2), false);
  EXPECT_TRUE(resumed.field.ReadState().parameters == whole.field.ReadState().parameters);
  EXPECT_EQ(resumed.steps.rays(), 3u * 256u);
}

// A step of Adam is as long for any gradient, so the fields differ only by the decay.
TEST(TrainingSteps, LetDensityDecayForPhotosAndNotForPicturesWithAlpha) {
  const auto densities = [](bool has_alpha, std::optional<double> decay) {
    OptimizeOptions options = SmallRunOptions();
    options.density_decay = decay;
    options.color_rate = 0.02;
    options.density_rate = 0.2;
    options.background = BackgroundChoice::kRandom;  // as photos have it, too
    SmallRun run(options);
    TrainingSteps steps(run.options, has_alpha, run.batches, *run.renderer, run.motion);
    steps.Take(AtProgress(0.1), false);
    return run.field.ReadState().parameters;
  };
  EXPECT_TRUE(densities(true, {}) == densities(false, 0.0));
  EXPECT_TRUE(densities(false, {}) == densities(true, 0.05));
  EXPECT_TRUE(densities(true, {}) != densities(false, {}));
}

TEST(TrainingSteps, AreSmallerForPhotosThanForPicturesWithAlphaUnlessRatesAreGiven) {
  const OptimizeOptions defaults;
  const FirstRates photos = FirstRatesOf(defaults, false), pictures = FirstRatesOf(defaults, true);
  EXPECT_LT(photos.color, pictures.color);
  EXPECT_LT(photos.density, pictures.density);
  EXPECT_LT(photos.harmonics, pictures.harmonics);
  const auto after_a_step = [](bool has_alpha, const FirstRates& rates) {
    OptimizeOptions options = SmallRunOptions();
    options.density_decay = 0.0;
    options.background = BackgroundChoice::kRandom;  // as photos have it, too
    SmallRun given(options), usual(options);
    given.options.color_rate = rates.color;
    given.options.density_rate = rates.density;
    given.options.harmonics_rate = rates.harmonics;
    for (SmallRun* run : {&given, &usual}) {
      TrainingSteps steps(run->options, has_alpha, run->batches, *run->renderer, run->motion);
      steps.Take(AtProgress(0.1), false);
    }
    return given.field.ReadState().parameters == usual.field.ReadState().parameters;
  };
  EXPECT_TRUE(after_a_step(false, photos));
  EXPECT_TRUE(after_a_step(true, pictures));
  EXPECT_FALSE(after_a_step(false, pictures));
}

// The scene's background is black here, in front of which a black field looks the same whatever its
// density.
TEST(TrainingSteps, LearnOpacityFromAlphaInFrontOfTheScenesBackground) {
  const auto steps = [](BackgroundChoice background, bool has_alpha) {
    OptimizeOptions options = SmallRunOptions();
    options.background = background;
    options.density_decay = 0.0;
    SmallRun run(options, 5, WavyBox(0.4, 0.5f));
    RadianceField black = WavyBox(0.4, 20.0f);
    std::fill(black.color_srgb.begin(), black.color_srgb.end(), glm::vec3(0.0f));
    const FieldState start = StateOf(black);
    run.field.Put(std::move(black.mesh), start);
    TrainingSteps(run.options, has_alpha, run.batches, *run.renderer, run.motion)
        .Take(AtProgress(0.1), false);
    const std::vector<float> end = run.field.ReadState().parameters;
    size_t clearer = 0, denser = 0;
    for (size_t i = kDensityOffset; i < end.size(); i += kStandardComponents) {
      clearer += end[i] < start.parameters[i];
      denser += end[i] > start.parameters[i];
    }
    return std::pair(clearer, denser);
  };
  using enum BackgroundChoice;
  const std::pair<size_t, size_t> none(0, 0);
  EXPECT_EQ(steps(kScene, true), none);
  const auto [clearer, denser] = steps(kAuto, true);
  EXPECT_GT(clearer, 10u);
  EXPECT_EQ(denser, 0u);
  EXPECT_EQ(steps(kAuto, false), steps(kRandom, false));
  EXPECT_NE(steps(kRandom, false), none);
}

TEST(BatchDrawer, DrawsAsManyRaysAndViewsAsKeepTheDeviceBusy) {
  OptimizeOptions options = SmallRunOptions();
  options.rays_per_step.reset();
  options.renderer.pace = {.rays_per_step = 2048, .views_per_batch = 2};
  SmallRun run(options);
  EXPECT_EQ(run.batches.Draw(1).rays(), 2048u);
  const auto views_of = [&](uint64_t iteration) {
    std::set<uint32_t> views;
    for (const RayBlock& block : run.batches.Draw(iteration).blocks) views.insert(block.view);
    return views.size();
  };
  EXPECT_GT(views_of(1), 2u);
  run.batches.UseFewViews(true);
  for (uint64_t i = 1; i <= 10; ++i) EXPECT_LE(views_of(i), 2u);

  options.rays_per_step = 64;
  EXPECT_EQ(SmallRun(options).batches.Draw(1).rays(), 64u);
}

TEST(BatchDrawer, CountsTheBlocksOfABatch) {
  OptimizeOptions options = SmallRunOptions();
  options.renderer.pace = {.views_per_batch = 2};
  SmallRun run(options);
  std::vector<RayBlock> blocks(6);
  for (size_t i = 0; i < blocks.size(); ++i) blocks[i].view = uint32_t(i / 2);
  EXPECT_EQ(run.batches.CountOfBatch(blocks, 5), 5u);
  EXPECT_EQ(run.batches.CountOfBatch(blocks, 10), 6u);
  run.batches.UseFewViews(true);
  EXPECT_EQ(run.batches.CountOfBatch(blocks, 10), 4u);
  EXPECT_EQ(run.batches.CountOfBatch(blocks, 3), 3u);
  EXPECT_EQ(run.batches.CountOfBatch(std::span(blocks).first(2), 10), 2u);
}

TEST(BatchDrawer, DrawsTilesNoLargerThanThePictures) {
  OptimizeOptions options = SmallRunOptions();
  options.rays_per_step.reset();
  options.renderer.pace = {.rays_per_step = 65536};
  options.loss.dssim = 0.2;
  SmallRun run(options);
  for (const RayBlock& block : run.batches.Draw(1).blocks) {
    const TargetImage& picture = run.pictures.set().targets[block.view];
    ASSERT_LE(int(block.x) + kRayBlockWidth, picture.width);
    ASSERT_LE(int(block.y) + kRayBlockHeight, picture.height);
  }
}

TEST(BatchDrawer, DrawsFewRaysOnEveryDeviceIfDeterministic) {
  OptimizeOptions options = SmallRunOptions();
  options.rays_per_step.reset();
  options.renderer.pace = {.rays_per_step = 65536};
  options.renderer.deterministic = true;
  EXPECT_EQ(SmallRun(options).batches.rays_per_step(), 4096);
}

// Blocks of fine rays are halves of the blocks that would have been drawn, inside the same
// pictures.
TEST(BatchDrawer, DrawsFineRaysThroughTheSamePixels) {
  SmallRun run;
  bool has_half[2][2] = {};
  for (uint64_t iteration = 0; iteration < 20; ++iteration) {
    const TrainingBatch coarse = run.batches.Draw(iteration);
    const std::vector<RayBlock> blocks(coarse.blocks.begin(), coarse.blocks.end());
    const TrainingBatch fine = run.batches.Draw(iteration, 2);
    EXPECT_EQ(coarse.samples, 1);
    EXPECT_EQ(fine.samples, 2);
    ASSERT_EQ(fine.blocks.size(), blocks.size());
    for (size_t i = 0; i < blocks.size(); ++i) {
      EXPECT_EQ(fine.blocks[i].view, blocks[i].view);
      const uint32_t right = fine.blocks[i].x / 2 - blocks[i].x;
      const uint32_t down = fine.blocks[i].y / 2 - blocks[i].y;
      EXPECT_TRUE(fine.blocks[i].x % 2 == 0 && fine.blocks[i].y % 2 == 0);
      ASSERT_TRUE((right == 0 || right == 2) && (down == 0 || down == 1));
      has_half[right / 2][down] = true;
    }
  }
  EXPECT_TRUE(has_half[0][0] && has_half[0][1] && has_half[1][0] && has_half[1][1]);
}

}  // namespace
}  // namespace tetrec
