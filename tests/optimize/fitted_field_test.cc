#include "optimize/fitted_field.h"

#include "optimize/ring_scene.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace tetrec {
namespace {

// A dense box that the cameras of RingOfCameras stand in.
RadianceField LargeBox() {
  RadianceField box = WavyBox(0.4);
  for (glm::vec3& position : box.mesh.positions) position *= 4.0f;
  return box;
}

// The densities of the vertices after it was put.
std::vector<float> DensityOf(FittedField& field, const RadianceField& box) {
  field.Put(box.mesh, StateOf(box));
  return FieldOf(field.mesh(), field.ReadState()).density;
}

TEST(FittedField, HasNoDensityWhereTheCamerasStand) {
  SmallRun run;
  const Scene scene = RingOfCameras(12, 500);
  const RadianceField box = LargeBox();
  const std::vector<uint8_t> is_inside = InsideCapsules(box.mesh.positions, FindCameraSpace(scene));
  OptimizeOptions options = run.options;
  options.camera_space = SpaceContent::kEmpty;
  FittedField field(options, scene, *run.renderer, run.batches);
  const std::vector<float> density = DensityOf(field, box);
  for (size_t v = 0; v < density.size(); ++v) {
    if (is_inside[v]) {
      EXPECT_LT(density[v], 1e-20f) << v;
    } else {
      EXPECT_NEAR(density[v], box.density[v], 1e-5f * box.density[v]) << v;
    }
  }
  EXPECT_GT(field.emptied_rows(), 0u);
  EXPECT_EQ(field.emptied_rows(), uint64_t(std::count(is_inside.begin(), is_inside.end(), 1)));

  field.Put(box.mesh, StateOf(box, SignedDensity(1.0f)));
  const RadianceField any_sign = FieldOf(field.mesh(), field.ReadState());
  for (size_t v = 0; v < is_inside.size(); ++v)
    EXPECT_EQ(any_sign.density[v] < 0, is_inside[v] != 0);

  FittedField learned(run.options, scene, *run.renderer, run.batches);
  EXPECT_EQ(learned.emptied_rows(), 0u);
  for (const float value : DensityOf(learned, box)) EXPECT_GT(value, 1.0f);
}

TEST(FittedField, HasNoDensityWherePhotosSeeNothing) {
  SmallRun run;
  Scene scene = RingOfCameras(2, 0);
  std::vector<StereoDepth> maps;
  for (uint32_t view = 0; view < 2; ++view) {
    scene.views[view].cam_from_world = {glm::dmat3(1.0), {0.0, 0.0, 4.0}};
    maps.push_back(MakeStereoDepth(view, scene.cameras[0]));
    std::fill(maps[view].depth.begin(), maps[view].depth.end(), 4.0f);
    std::fill(maps[view].agreement.begin(), maps[view].agreement.end(), uint8_t(2));
  }
  const RadianceField box = LargeBox();
  const PhotoSight sight(scene, maps);
  const std::vector<PlaceSight> sights = sight.Of(box.mesh.positions);
  FittedField field(run.options, scene, *run.renderer, run.batches, sight);
  const std::vector<float> density = DensityOf(field, box);
  for (size_t v = 0; v < density.size(); ++v) {
    EXPECT_EQ(density[v] < 1e-20f, sights[v].is_empty) << v;
  }
  EXPECT_GT(field.seen_empty_rows(), 0u);
  EXPECT_LT(field.seen_empty_rows(), density.size());
  EXPECT_EQ(field.emptied_rows(), 0u);
  run.options.seen_space = SpaceContent::kLearned;
  FittedField learned(run.options, scene, *run.renderer, run.batches, sight);
  DensityOf(learned, box);
  EXPECT_EQ(learned.seen_empty_rows(), 0u);
}

// The whole box is in the frame of each photo, and all of it is denser than 1.
TEST(FittedField, KeepsTheDensityOfSurfacesWhereManyPhotosLook) {
  const auto after_a_step = [](int photos, double decay, double density_of_surfaces) {
    OptimizeOptions options = SmallRunOptions();
    options.density_decay = decay;
    SmallRun run(options);
    Scene scene = RingOfCameras(photos, 0);
    for (View& view : scene.views) view.cam_from_world = {glm::dmat3(1.0), {0.0, 0.0, 4.0}};
    FittedField field(run.options, scene, *run.renderer, run.batches, PhotoSight(scene),
                      density_of_surfaces);
    const RadianceField box = WavyBox(0.4);
    field.Put(box.mesh, StateOf(box));
    run.steps.Take(AtProgress(0.1), false);
    return field.ReadState().parameters;
  };
  const auto with_decay = [&](int photos, double density_of_surfaces) {
    return after_a_step(photos, 0.05, density_of_surfaces);
  };
  const std::vector<float> kept = after_a_step(13, 0.0, 1.0), decayed = with_decay(13, 1e6);
  EXPECT_TRUE(kept != decayed);
  EXPECT_TRUE(with_decay(13, 1.0) == kept);
  EXPECT_TRUE(with_decay(12, 1.0) == decayed);
}

// Depth maps show the middle of a box, and its photos show nothing: all of it should go.
TEST(FittedField, KeepsSurfacesOnWhichDepthMapsAgree) {
  for (const uint32_t photos : {3u, 21u}) {
    SmallRun run(SmallRunOptions(), 5, WavyBox(0.4, 0.0f));
    Scene scene = RingOfCameras(int(photos), 0);
    std::vector<StereoDepth> maps;
    for (uint32_t view = 0; view < photos; ++view) {
      scene.views[view].cam_from_world = {glm::dmat3(1.0), {0.0, 0.0, 40.0}};
      maps.push_back(MakeStereoDepth(view, scene.cameras[0]));
      std::fill(maps[view].depth.begin(), maps[view].depth.end(), 40.0f);
      std::fill(maps[view].agreement.begin(), maps[view].agreement.end(), uint8_t(2));
    }
    RadianceField box = WavyBox(0.4);
    std::fill(box.density.begin(), box.density.end(), 0.1f);
    const PhotoSight sight(scene, maps);
    const std::vector<PlaceSight> sights = sight.Of(box.mesh.positions);
    const uint64_t surface = uint64_t(std::ranges::count(sights, true, &PlaceSight::is_surface));
    FittedField field(run.options, scene, *run.renderer, run.batches, sight, 0.5);
    const std::vector<float> before = DensityOf(field, box);
    for (int i = 0; i < 20; ++i) run.steps.Take(AtProgress(0.1), false);
    const std::vector<float> after = FieldOf(field.mesh(), field.ReadState()).density;
    const float least = photos == 3 ? 2.5f : 1.0f;
    size_t others_fell = 0;
    for (size_t v = 0; v < before.size(); ++v) {
      EXPECT_NEAR(before[v], sights[v].is_surface ? least : 0.1f, 1e-5f) << v;
      EXPECT_TRUE(!sights[v].is_surface || after[v] >= 0.9999f * least) << v;
      others_fell += !sights[v].is_surface && after[v] < 0.9f * before[v];
    }
    EXPECT_GT(others_fell, 0u);
    EXPECT_GT(surface, 0u);
    EXPECT_LT(surface, before.size());
    EXPECT_EQ(field.kept_surface_rows(), surface);
    run.options.seen_surfaces = SurfaceContent::kLearned;
    FittedField learned(run.options, scene, *run.renderer, run.batches, sight, 0.5);
    for (const float density : DensityOf(learned, box)) EXPECT_NEAR(density, 0.1f, 1e-5f);
    EXPECT_EQ(learned.kept_surface_rows(), 0u);
  }
}

// A resumed run must do what the run would have done, wherever vertices have moved.
TEST(FittedField, ResumesWithTheRatesOfACheckpoint) {
  SmallRun run;
  FittedField field(run.options, RingOfCameras(12, 0), *run.renderer, run.batches);
  const RadianceField box = WavyBox(0.4);
  field.Put(box.mesh, StateOf(box));
  std::vector<RowRates> rates = field.row_rates();
  rates[0].share = 0.0f;
  rates[1].kept_density = 2.5f;
  rates[2].least_density = 0.5f;
  field.Resume(box.mesh, StateOf(box), rates);
  EXPECT_EQ(field.row_rates()[0].share, 0.0f);
  EXPECT_EQ(field.row_rates()[1].kept_density, 2.5f);
  EXPECT_EQ(field.kept_surface_rows(), 1u);
  EXPECT_EQ(field.emptied_rows() + field.seen_empty_rows(), 1u);
  const std::vector<float> before = run.renderer->ReadState().parameters;
  EXPECT_TRUE(before == StateOf(box).parameters);
}

}  // namespace
}  // namespace tetrec
