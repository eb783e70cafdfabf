// Damages do what they say to the training views, and nothing to the views that judge.
#include "expect_error.h"
#include "stability/picture_damage.h"
#include "stability/point_damage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace tetrec {
namespace {

SceneWithImages Room() {
  return MakeSyntheticScene({.kind = SyntheticKind::kRoom,
                             .train_views = 12,
                             .validation_views = 0,
                             .test_views = 3,
                             .width = 16,
                             .height = 16,
                             .points = 40});
}

// Training views whose image or pose differs from the room's.
size_t ChangedViews(const SceneWithImages& damaged) {
  const SceneWithImages room = Room();
  size_t changed = 0;
  for (const int view : room.scene.ViewsOf(Split::kTrain)) {
    const auto& before = room.scene.views[size_t(view)].cam_from_world;
    const auto& after = damaged.scene.views[size_t(view)].cam_from_world;
    changed += room.images[size_t(view)].pixels != damaged.images[size_t(view)].pixels ||
               before.rotation != after.rotation;
  }
  return changed;
}

TEST(PictureDamage, LeavesHeldOutViewsAsTheyAre) {
  const std::function<void(SceneWithImages&)> damages[] = {
      [](SceneWithImages& given) { KeepTrainingViews(given, 5); },
      RepeatEveryThirdView,
      [](SceneWithImages& given) { TurnOneCamera(given, 5); },
      BlackenOneImage,
      [](SceneWithImages& given) { ExposeOneImage(given, 2); },
      [](SceneWithImages& given) { BlurHalfOfImages(given, 2); },
      [](SceneWithImages& given) { AddNoise(given, 0.05, 1); }};
  const SceneWithImages room = Room();
  for (const auto& damage : damages) {
    SceneWithImages damaged = room;
    damage(damaged);
    ASSERT_EQ(damaged.images.size(), damaged.scene.views.size());
    const std::vector<int> before = room.scene.HeldOutViews();
    const std::vector<int> after = damaged.scene.HeldOutViews();
    ASSERT_EQ(before.size(), after.size());
    for (size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(room.images[size_t(before[i])].pixels, damaged.images[size_t(after[i])].pixels);
      EXPECT_EQ(room.scene.views[size_t(before[i])].name,
                damaged.scene.views[size_t(after[i])].name);
    }
  }
}

TEST(PictureDamage, KeepsFewViewsFromTheWholeRange) {
  SceneWithImages few = Room();
  KeepTrainingViews(few, 5);
  ASSERT_EQ(few.scene.ViewsOf(Split::kTrain).size(), 5u);
  EXPECT_EQ(few.scene.views[0].name, "train/000");
  EXPECT_EQ(few.scene.views[4].name, "train/009");
  SceneWithImages all = Room();
  KeepTrainingViews(all, 100);
  EXPECT_EQ(ChangedViews(all), 0u);
}

TEST(PictureDamage, RepeatsViewsUnderOtherNames) {
  SceneWithImages twice = Room();
  RepeatEveryThirdView(twice);
  ASSERT_EQ(twice.scene.ViewsOf(Split::kTrain).size(), 16u);
  const View& again = twice.scene.views.back();
  EXPECT_EQ(again.name, "train/009-again");
  EXPECT_EQ(again.image, "images/train/009-again.png");
  EXPECT_EQ(twice.images.back().pixels, twice.images[9].pixels);
}

TEST(PictureDamage, TurnsACameraAboutItsOwnCentre) {
  SceneWithImages turned = Room();
  const Rigid3 before = turned.scene.views[6].cam_from_world;
  TurnOneCamera(turned, 5);
  EXPECT_EQ(ChangedViews(turned), 1u);
  const Rigid3 after = turned.scene.views[6].cam_from_world;
  EXPECT_LT(glm::length(before.Inverse().translation - after.Inverse().translation), 1e-12);
  const glm::dmat3 turn = after.rotation * glm::transpose(before.rotation);
  const double cosine = 0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1);
  EXPECT_NEAR(std::acos(cosine) * 180 / std::numbers::pi, 5, 1e-6);
}

TEST(PictureDamage, DoublesTheLightOfOneImage) {
  SceneWithImages exposed = Room();
  const uint8_t before = exposed.images[6].pixels[0];
  ExposeOneImage(exposed, 2);
  EXPECT_EQ(ChangedViews(exposed), 1u);
  // Twice the light is 2^(1/2.4) = 1.33 times the value in sRGB, a little more by its offset.
  EXPECT_NEAR(exposed.images[6].pixels[0] + 14, 1.335 * (before + 14), 2) << int(before);
}

TEST(PictureDamage, BlursHalfOfTheImagesAndKeepsTheirMean) {
  SceneWithImages blurred = Room();
  const auto mean_and_variance = [](const Image& image) {
    double sum = 0, squares = 0;
    for (const uint8_t value : image.pixels) sum += value, squares += double(value) * value;
    const double mean = sum / double(image.pixels.size());
    return std::pair(mean, squares / double(image.pixels.size()) - mean * mean);
  };
  const auto [mean, variance] = mean_and_variance(blurred.images[0]);
  BlurHalfOfImages(blurred, 2);
  EXPECT_EQ(ChangedViews(blurred), 6u);
  const auto [blurred_mean, blurred_variance] = mean_and_variance(blurred.images[0]);
  EXPECT_NEAR(blurred_mean, mean, 5);  // pixels at the border count more than before
  EXPECT_LT(blurred_variance, 0.8 * variance);
}

TEST(PictureDamage, AddsNoiseOfTheGivenDeviation) {
  SceneWithImages noisy = Room();
  AddNoise(noisy, 0.05, 3);
  EXPECT_EQ(ChangedViews(noisy), 12u);
  const SceneWithImages room = Room();
  double squares = 0, count = 0;
  for (size_t v = 0; v < 12; ++v) {
    for (size_t i = 0; i < room.images[v].pixels.size(); ++i, ++count) {
      squares += std::pow(double(noisy.images[v].pixels[i]) - room.images[v].pixels[i], 2);
    }
  }
  // 9,216 values: a standard error of 0.7 %, and some are clipped.
  EXPECT_NEAR(std::sqrt(squares / count), 0.05 * 255, 0.04 * 0.05 * 255);
}

TEST(PictureDamage, KeepsAlpha) {
  const SceneWithImages ball = MakeSyntheticScene({.width = 16, .height = 16});
  SceneWithImages damaged = ball;
  BlackenOneImage(damaged);
  AddNoise(damaged, 0.05, 1);
  for (size_t i = 0; i < ball.images.size(); ++i) {
    EXPECT_EQ(AlphaOf(ball.images[i]), AlphaOf(damaged.images[i]));
  }
}

TEST(PointDamage, MovesAShareOfThePoints) {
  const Scene room = Room().scene;
  Scene wrong = room;
  MisplacePoints(wrong, 0.25, 1);
  size_t moved = 0;
  for (size_t i = 0; i < room.points.size(); ++i) {
    moved += room.points[i].position != wrong.points[i].position;
  }
  EXPECT_GT(moved, 3u);  // 10 of 40 are expected
  EXPECT_LT(moved, 20u);
}

TEST(PointDamage, MakesPointsCoplanarCoincidentOrFew) {
  Scene flat = Room().scene, one = flat, three = flat;
  FlattenPoints(flat);
  CollapsePoints(one);
  KeepPoints(three, 3);
  EXPECT_EQ(three.points.size(), 3u);
  for (size_t i = 0; i < flat.points.size(); ++i) {
    EXPECT_EQ(flat.points[i].position.z, 0);
    EXPECT_EQ(one.points[i].position, glm::dvec3(0.0));
  }
}

}  // namespace
}  // namespace tetrec
