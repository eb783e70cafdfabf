#include "optimize/judging.h"

#include "core/random.h"
#include "mesh/delaunay.h"
#include "render/create_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>

namespace tetrec {
namespace {

constexpr uint32_t kGrey = 0xFF808080u;

// Views whose targets are grey, whose cameras look away from any field.
TrainingSet GreySet(size_t views, int width, int height) {
  TrainingSet set;
  for (size_t v = 0; v < views; ++v) {
    RenderView view;
    view.camera = {width, height, double(width), double(width), 0.5 * width, 0.5 * height};
    view.cam_from_world.translation = {0, 0, 100};
    set.views.push_back(view);
    set.targets.push_back({width, height, std::vector<uint32_t>(size_t(width) * height, kGrey)});
    set.pixels += size_t(width) * height;
  }
  ListBlocks(set, {});
  return set;
}

TEST(JudgingSet, KeepsOneTileInThirtyTwoAndWholeViewsOnlyOfManyPhotos) {
  const TrainingSet few = GreySet(10, 256, 192);
  const JudgingSet of_few = ChooseJudgingSet(few, 1);
  EXPECT_EQ(of_few.is_whole, std::vector<uint8_t>(10, 0));
  // 1,920 tiles: binomial, so five standard deviations are 0.4 of the mean.
  EXPECT_NEAR(double(of_few.blocks.size()) / double(few.blocks.size()), 1.0 / 32, 0.4 / 32);

  const JudgingSet of_many = ChooseJudgingSet(GreySet(40, 64, 48), 1);
  EXPECT_EQ(std::count(of_many.is_whole.begin(), of_many.is_whole.end(), uint8_t{1}), 2);
}

TEST(JudgingSet, DependsOnTheSeedOnly) {
  const TrainingSet set = GreySet(10, 256, 192);
  const auto keys = [&](uint64_t seed) {
    std::vector<std::tuple<uint32_t, uint32_t, uint32_t>> result;
    for (const RayBlock& b : ChooseJudgingSet(set, seed).blocks) {
      result.emplace_back(b.view, b.x, b.y);
    }
    return result;
  };
  EXPECT_EQ(keys(1), keys(1));
  EXPECT_NE(keys(1), keys(2));
}

TEST(JudgingSet, PartsEveryPixelBetweenLearningAndJudging) {
  const TrainingSet set = GreySet(24, 70, 50);  // not a multiple of tiles or blocks
  const JudgingSet judging = ChooseJudgingSet(set, 3);
  const std::vector<TargetImage> learn = TargetsToLearn(set, judging);
  std::vector<std::vector<bool>> judge(set.targets.size(), std::vector<bool>(70 * 50, false));
  for (const RayBlock& block : judging.blocks) {
    for (uint32_t y = block.y; y < std::min(block.y + kRayBlockHeight, 50u); ++y) {
      for (uint32_t x = block.x; x < std::min(block.x + kRayBlockWidth, 70u); ++x) {
        judge[block.view][y * 70 + x] = true;
      }
    }
  }
  size_t judged = 0;
  for (size_t v = 0; v < set.targets.size(); ++v) {
    for (size_t i = 0; i < set.targets[v].rgba8.size(); ++i) {
      const bool judges = judge[v][i];
      EXPECT_EQ(learn[v].rgba8[i], judges ? kNotJudgedTarget : kGrey);
      if (judging.is_whole[v]) {  // a chessboard of tiles
        EXPECT_EQ(judges, (i % 70 / 16 + i / 70 / 16) % 2 == 0);
      }
      judged += judges;
    }
  }
  EXPECT_GT(judged, 0u);
}

TEST(JudgingSet, LeavesTheBlocksOfWholeViewsOutOfTheDraw) {
  TrainingSet set = GreySet(24, 64, 48);
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  const size_t all = set.blocks.size();
  ListBlocks(set, judging.is_whole);
  EXPECT_EQ(set.blocks.size(), all - all / 24);
  for (const RayBlock& block : set.blocks.List()) EXPECT_EQ(judging.is_whole[block.view], 0);
  ListBlocks(set, {});
  EXPECT_EQ(set.blocks.size(), all);
}

// Its pictures show the background alone, so every residual is known.
std::unique_ptr<TrainingRenderer> RendererOfNothing() {
  auto renderer = CreateRenderer({.kind = RendererKind::kReference});
  RadianceField field;
  field.mesh =
      BuildDelaunay(std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}).mesh;
  field.density.assign(4, 0.0f);
  field.color_srgb.assign(4, glm::vec3(0.0f));
  renderer->SetState(field.mesh, StateOf(field));
  return renderer;
}

TEST(Judge, GivesThePsnrOfTheJudgingPixelsAndItsStandardError) {
  TrainingSet set = GreySet(24, 64, 48);
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  ASSERT_EQ(std::count(judging.is_whole.begin(), judging.is_whole.end(), uint8_t{1}), 1);
  const auto renderer = RendererOfNothing();
  renderer->SetTargets(set.views, set.targets);

  const double residual = 128.0 / 255.0 - 0.25;
  const Judgement judgement = Judge(*renderer, judging, glm::vec3(0.25f));
  EXPECT_NEAR(judgement.psnr, -20 * std::log10(residual), 1e-4);
  EXPECT_NEAR(judgement.views_psnr, judgement.psnr, 1e-9);
  EXPECT_NEAR(judgement.tiles_psnr, judgement.psnr, 1e-9);
  EXPECT_NEAR(judgement.standard_error, 0.0, 1e-6);

  // The whole view becomes black: it alone gets better, and the views no longer agree.
  for (size_t v = 0; v < set.targets.size(); ++v) {
    if (judging.is_whole[v]) {
      set.targets[v].rgba8.assign(set.targets[v].rgba8.size(), 0xFF000000u);
    }
  }
  renderer->SetTargets(set.views, set.targets);
  const Judgement mixed = Judge(*renderer, judging, glm::vec3(0.25f));
  EXPECT_NEAR(mixed.views_psnr, -20 * std::log10(0.25), 1e-4);
  EXPECT_NEAR(mixed.tiles_psnr, judgement.psnr, 1e-9);
  EXPECT_GT(mixed.standard_error, 0.001);
}

TEST(Judge, CountsOnlyPixelsThatMasksLeave) {
  TrainingSet set = GreySet(24, 64, 48);
  for (TargetImage& target : set.targets) {
    for (size_t i = 0; i < target.rgba8.size(); ++i) {
      if (i % 64 < 45) target.rgba8[i] = kNotJudgedTarget;
    }
  }
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  for (const RayBlock& block : judging.blocks) EXPECT_GE(block.x, 44u);
  const auto renderer = RendererOfNothing();
  renderer->SetTargets(set.views, set.targets);
  for (const int samples : {1, 2}) {
    const Judgement judgement = Judge(*renderer, judging, glm::vec3(0.25f), samples);
    EXPECT_NEAR(judgement.psnr, -20 * std::log10(128.0 / 255.0 - 0.25), 1e-4) << samples;
  }
}

TEST(Judge, LooksAtSomeBlocksOfEveryViewIfManyPixelsJudge) {
  const TrainingSet set = GreySet(24, 640, 480);
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  const double all = double(judging.blocks.size() * kRaysPerBlock);
  ASSERT_GT(all, 2.0 * kMostJudgedPixels);
  const auto renderer = RendererOfNothing();
  renderer->SetTargets(set.views, set.targets);
  const Judgement judgement = Judge(*renderer, judging, glm::vec3(0.25f));
  EXPECT_NEAR(judgement.psnr, -20 * std::log10(128.0 / 255.0 - 0.25), 1e-4);
  ASSERT_EQ(judgement.views.size(), set.views.size());
  double judged = 0;
  for (const ErrorSum& view : judgement.views) judged += view.rays;
  EXPECT_LE(judged, double(kMostJudgedPixels));
  for (size_t v = 0; v < set.views.size(); ++v) {
    const auto is_of_view = [&](const RayBlock& block) { return block.view == v; };
    const double of_view =
        double(std::ranges::count_if(judging.blocks, is_of_view) * kRaysPerBlock);
    EXPECT_NEAR(judgement.views[v].rays / of_view, judged / all, 0.01) << v;
  }
}

// A view without rays would be refused where a run is resumed.
TEST(Judge, LooksAtABlockOfEveryViewHoweverFewItHas) {
  TrainingSet set = GreySet(24, 64, 48);
  for (size_t i = 0; i < set.targets[3].rgba8.size(); ++i) {
    if (i >= 64 * 16) set.targets[3].rgba8[i] = kNotJudgedTarget;
  }
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  const auto renderer = RendererOfNothing();
  renderer->SetTargets(set.views, set.targets);
  for (const ErrorSum& view : Judge(*renderer, judging, glm::vec3(0.25f), 1, 64).views) {
    EXPECT_GT(view.rays, 0.0);
  }
}

TEST(GainBetween, HasNoErrorWhereAllViewsGainAlike) {
  const std::vector<ErrorSum> before = {{2.0, 100}, {9.0, 300}, {0.5, 50}};
  std::vector<ErrorSum> after = before;
  for (ErrorSum& view : after) view.squares /= 2;
  const JudgedGain gain = GainBetween(before, after);
  EXPECT_NEAR(gain.gain, 10 * std::log10(2.0), 1e-12);
  EXPECT_NEAR(gain.standard_error, 0.0, 1e-12);
}

// Leaving out one view after another (the jackknife) estimates the same error in another way.
TEST(GainBetween, HasTheErrorThatTheJackknifeFinds) {
  std::vector<ErrorSum> before, after;
  Random random(8);
  for (int view = 0; view < 60; ++view) {
    const double rays = 100.0 + std::floor(50 * random.Uniform());
    const double squares = rays * (0.01 + 0.01 * random.Uniform());
    before.push_back({squares, rays});
    after.push_back({squares * (0.8 + 0.3 * random.Uniform()), rays});
  }
  const JudgedGain gain = GainBetween(before, after);
  double mean = 0, squares = 0;
  std::vector<double> gains;
  for (size_t left_out = 0; left_out < before.size(); ++left_out) {
    std::vector<ErrorSum> some_before = before, some_after = after;
    some_before.erase(some_before.begin() + long(left_out));
    some_after.erase(some_after.begin() + long(left_out));
    gains.push_back(GainBetween(some_before, some_after).gain);
    mean += gains.back() / double(before.size());
  }
  for (const double one : gains) squares += (one - mean) * (one - mean);
  const double jackknife = std::sqrt(squares * double(gains.size() - 1) / double(gains.size()));
  EXPECT_GT(gain.gain, 0.1);
  EXPECT_NEAR(gain.standard_error, jackknife, 0.05 * jackknife);
}

TEST(GainBetween, IsUnknownBetweenOtherViews) {
  const std::vector<ErrorSum> two = {{1.0, 10}, {2.0, 10}}, one = {{1.0, 10}};
  EXPECT_EQ(GainBetween({}, two).gain, 0.0);
  EXPECT_EQ(GainBetween(one, two).gain, 0.0);
}

TEST(SampleViews, TakesSoManyBlocksOfEachViewThatMasksDoNotHide) {
  TrainingSet set = GreySet(3, 32, 16);
  std::fill_n(set.targets[1].rgba8.begin(), 32 * 15, kNotJudgedTarget);  // a row is left
  set.targets[2].rgba8.assign(32 * 16, kNotJudgedTarget);
  const JudgingSet sample = SampleViews(set, 10);
  const auto blocks_of = [&](uint32_t view) {
    return std::ranges::count(sample.blocks, view, &RayBlock::view);
  };
  EXPECT_EQ(blocks_of(0), 10);
  EXPECT_EQ(blocks_of(1), 8);  // all of the last row
  EXPECT_EQ(blocks_of(2), 0);
  ASSERT_EQ(sample.pixels.size(), 18u);
  EXPECT_EQ(sample.pixels.front(), 8);
  EXPECT_EQ(sample.pixels.back(), 4);
  EXPECT_TRUE(std::ranges::is_sorted(sample.blocks, {}, &RayBlock::view));
}

TEST(Without, LeavesNothingOfTheViewsThatAreLeftOut) {
  const TrainingSet set = GreySet(32, 32, 32);  // views 8 and 24 are whole
  const JudgingSet judging = ChooseJudgingSet(set, 1);
  std::vector<uint8_t> left_out(32, 0);
  left_out[8] = left_out[judging.blocks.front().view] = 1;
  const JudgingSet rest = Without(judging, left_out);
  EXPECT_LT(rest.blocks.size(), judging.blocks.size());
  EXPECT_EQ(rest.blocks.size(), rest.pixels.size());
  EXPECT_LT(rest.spare_blocks.size(), judging.spare_blocks.size());
  EXPECT_FALSE(rest.spare_blocks.empty());
  for (const RayBlock& block : rest.blocks) EXPECT_FALSE(left_out[block.view]);
  for (const RayBlock& block : rest.spare_blocks) EXPECT_FALSE(left_out[block.view]);
  EXPECT_EQ(Without(judging, {}).blocks.size(), judging.blocks.size());
}

}  // namespace
}  // namespace tetrec
