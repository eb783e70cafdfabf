#include "optimize/camera_poses.h"

#include "core/random.h"
#include "geometry/small_motion.h"
#include "optimize/wavy_box.h"
#include "render/create_renderer.h"
#include "render/view_pose.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

double Shift(const RenderView& from, const Rigid3& to) {
  return PictureShift(from.camera, to * from.cam_from_world.Inverse(), 2.0);
}

class CameraPoses : public ::testing::Test {
 protected:
  std::unique_ptr<TrainingRenderer> renderer_ = CreateRenderer({.kind = RendererKind::kReference});

  PoseFit Fit(const RenderView& start, const TargetImage& photo, int iterations = 4,
              const std::optional<ViewExposure>& exposure = ViewExposure{}) {
    return FitPose(*renderer_, {start, start.cam_from_world, photo, exposure, glm::vec3(0.0f)},
                   {.pixels = 200, .iterations = iterations});
  }
};

// Two of the six numbers, a turn and a move along the picture, do almost the same to it, so the
// pull towards the start leaves some of their difference. What the picture tells is found.
TEST_F(CameraPoses, ATurnedAndMovedCameraIsBroughtBack) {
  renderer_->SetField(WavyBox(0.4));
  const RenderView truth = ViewFrom({2.2, 1.0, 1.2});
  RenderView start = truth;
  start.cam_from_world = MotionOf(glm::radians(glm::dvec3(0.8, -0.6, 0.5)), {0.02, -0.01, 0.02}) *
                         start.cam_from_world;
  ASSERT_GT(Shift(truth, start.cam_from_world), 1.0);
  const PoseFit fit = Fit(start, PhotoOf(*renderer_, truth));
  EXPECT_TRUE(fit.is_better);
  EXPECT_LT(Shift(truth, fit.cam_from_world), 0.2);
}

TEST_F(CameraPoses, ACameraThatIsRightStays) {
  renderer_->SetField(WavyBox(0.4));
  const RenderView truth = ViewFrom({2.2, 1.0, 1.2});
  const PoseFit fit = Fit(truth, PhotoOf(*renderer_, truth));
  EXPECT_LT(Shift(truth, fit.cam_from_world), 0.02);
}

TEST_F(CameraPoses, AViewOfOneColourStays) {
  renderer_->SetField(WavyBox(0.0));
  RenderView inside = ViewFrom({2.2, 1.0, 1.2});
  inside.camera.fx = inside.camera.fy = 400;  // sees nothing but the box
  const PoseFit fit = Fit(inside, PhotoOf(*renderer_, inside));
  EXPECT_LT(Shift(inside, fit.cam_from_world), 0.001);
  EXPECT_FALSE(fit.is_better);
}

TEST_F(CameraPoses, AViewWithoutAnyJudgedPixelStays) {
  renderer_->SetField(WavyBox(0.4));
  const RenderView view = ViewFrom({2.2, 1.0, 1.2});
  TargetImage photo = PhotoOf(*renderer_, view);
  photo.rgba8.assign(photo.rgba8.size(), kNotJudgedTarget);
  EXPECT_FALSE(Fit(view, photo).is_better);
}

// The exposure is not known and is fitted beside the pose.
TEST_F(CameraPoses, ADarkPhotoIsFittedWithItsExposure) {
  RadianceField field = WavyBox(0.4);
  renderer_->SetField(field);
  const RenderView truth = ViewFrom({2.2, 1.0, 1.2});
  for (glm::vec3& color : field.color_srgb) color *= 0.7f;
  renderer_->SetField(field);
  const TargetImage photo = PhotoOf(*renderer_, truth);
  renderer_->SetField(WavyBox(0.4));
  RenderView start = truth;
  start.cam_from_world =
      MotionOf(glm::radians(glm::dvec3(0.8, -0.6, 0.5)), glm::dvec3(0.0)) * start.cam_from_world;
  const PoseFit fit = Fit(start, photo, 5, std::nullopt);
  EXPECT_TRUE(fit.is_better);
  EXPECT_LT(Shift(truth, fit.cam_from_world), 0.2);
}

TEST_F(CameraPoses, ASweepBringsBackTheWrongCameraAndLeavesTheOthers) {
  renderer_->SetField(WavyBox(0.4));
  const std::vector<RenderView> truth = Ring(5);
  std::vector<TargetImage> photos;
  for (const RenderView& view : truth) photos.push_back(PhotoOf(*renderer_, view));
  std::vector<RenderView> given = truth;
  given[2].cam_from_world =
      MotionOf(glm::radians(glm::dvec3(1.0, 0.0, 0.0)), {0.02, 0, 0}) * given[2].cam_from_world;
  PoseEstimate estimate(given);
  for (int sweep = 0; sweep < 2; ++sweep) {
    estimate.Sweep(*renderer_, {given, photos, {}, glm::vec3(0.0f)}, 1, 150);
  }
  ASSERT_GT(Shift(truth[2], given[2].cam_from_world), 0.8);
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT(Shift(truth[i], estimate.state().poses[i].cam_from_world), i == 2 ? 0.3 : 0.1) << i;
  }
}

TEST(CommonMotion, OfAllCamerasIsTakenBack) {
  const std::vector<RenderView> given = Ring(5);
  const Similarity3 world{
      1.01, MotionOf({0.01, -0.02, 0.015}, glm::dvec3(0.0)).rotation, {0.02, 0.01, -0.03}};
  std::vector<CorrectedPose> poses;
  for (const RenderView& view : given) {
    // The camera goes along with its world; lengths in its frame do not change.
    const glm::dmat3 rotation = view.cam_from_world.rotation * glm::transpose(world.rotation);
    const glm::dvec3 center = world * view.cam_from_world.Inverse().translation;
    poses.push_back({{rotation, -(rotation * center)}, 2.0});
    ASSERT_GT(Shift(view, poses.back().cam_from_world), 0.3);
  }
  RemoveCommonMotion(given, poses);
  for (size_t i = 0; i < given.size(); ++i) {
    EXPECT_LT(Shift(given[i], poses[i].cam_from_world), 1e-3) << i;
  }
}

TEST(CommonMotion, LeavesTheDifferencesOfCameras) {
  const std::vector<RenderView> given = Ring(12);
  std::vector<CorrectedPose> poses;
  for (const RenderView& view : given) poses.push_back({view.cam_from_world, 2.0});
  poses[3].cam_from_world =
      MotionOf(glm::dvec3(0.03, 0, 0), glm::dvec3(0.0)) * poses[3].cam_from_world;
  const double before = Shift(given[3], poses[3].cam_from_world);
  RemoveCommonMotion(given, poses);
  EXPECT_GT(Shift(given[3], poses[3].cam_from_world), 0.98 * before);
  for (size_t i = 0; i < given.size(); ++i) {
    if (i == 3) continue;
    EXPECT_LT(Shift(given[i], poses[i].cam_from_world), 0.02 * before) << i;
  }
}

TEST(CommonMotion, OfCamerasThatSeeNothingIsNone) {
  const std::vector<RenderView> given = Ring(4);
  std::vector<CorrectedPose> poses;
  for (const RenderView& view : given) poses.push_back({view.cam_from_world, 0.0});
  RemoveCommonMotion(given, poses);
  for (size_t i = 0; i < given.size(); ++i) {
    EXPECT_LT(Shift(given[i], poses[i].cam_from_world), 1e-12);
  }
}

TEST(PoseEstimate, IsOffForFewerThanThreeCamerasAndAfterItGaveUp) {
  EXPECT_FALSE(PoseEstimate(Ring(2)).IsDue(AtProgress(0.6)));
  PoseEstimate estimate(Ring(3));
  EXPECT_FALSE(estimate.IsDue(AtProgress(0.1)));
  EXPECT_TRUE(estimate.IsDue(AtProgress(0.6)));
  estimate.GiveUp();
  EXPECT_FALSE(estimate.IsDue(AtProgress(0.6)));
}

TEST(PoseEstimate, SweepsBeginAsEarlyInALongRunAsInAShortOneAndEndLate) {
  const PoseEstimate first(Ring(3));
  EXPECT_TRUE(first.IsDue({.progress = 0.01, .growth = 0.2}));
  PoseState later = first.state();
  later.sweeps = 12;
  const PoseEstimate estimate(later);
  EXPECT_FALSE(estimate.IsDue({.progress = 0.01, .growth = 0.2}));
  EXPECT_TRUE(estimate.IsDue({.progress = 0.3, .growth = 3}));
  EXPECT_FALSE(estimate.IsDue({.progress = 0.7, .growth = 7}));
}

}  // namespace
}  // namespace tetrec
