// The parts of a run on photos of a small scene, on the reference renderer.
#pragma once

#include "optimize/batches.h"
#include "optimize/fitted_field.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"
#include "optimize/wavy_box.h"
#include "render/create_renderer.h"

#include <memory>

namespace tetrec {

inline OptimizeOptions SmallRunOptions() {
  OptimizeOptions options;
  options.iterations = 100;
  options.rays_per_step = 256;
  options.camera_space = SpaceContent::kLearned;
  options.schedule.matched_psnr = 1000;  // the true field matches its photos
  options.seed = 7;                      // tiles of views 0, 2 and 4 judge
  return options;
}

// Photos of a field from a ring of cameras.
inline TrainingSet PhotosFromAround(TrainingRenderer& renderer, size_t views,
                                    const RadianceField& truth) {
  renderer.SetField(truth);
  TrainingSet set;
  set.views = Ring(views);
  for (const RenderView& view : set.views) {
    set.targets.push_back(PhotoOf(renderer, view));
    set.pixels += set.targets.back().rgba8.size();
  }
  ListBlocks(set, {});
  return set;
}

inline Scene SceneOfWavyBox() {
  Scene scene;
  scene.subject_bounds = {glm::dvec3(-1.0), glm::dvec3(1.0)};
  return scene;
}

// Its parts refer to each other, so it stays where it is.
struct SmallRun {
  explicit SmallRun(const OptimizeOptions& run_options = SmallRunOptions(), size_t views = 5,
                    const RadianceField& truth = WavyBox(0.4))
      : options(run_options),
        renderer(CreateRenderer({.kind = RendererKind::kReference,
                                 .orientations = run_options.renderer.orientations,
                                 .pace = run_options.renderer.pace})),
        pictures(options, PhotosFromAround(*renderer, views, truth), glm::vec3(0.0f), *renderer),
        batches(options, pictures.set(), *renderer, glm::vec3(0.0f), "scene"),
        field(options, SceneOfWavyBox(), *renderer, batches),
        motion(options, field, *renderer, views),
        steps(options, false, batches, *renderer, motion) {
    pictures.PlaceCameras({}, 0.0);
    PutField(0.4);
  }
  SmallRun(const SmallRun&) = delete;
  SmallRun& operator=(const SmallRun&) = delete;

  // The true field if its contrast is 0.4 and its mesh has 9 vertices a side.
  void PutField(double contrast, int side = 9) {
    RadianceField box = WavyBox(contrast, 20.0f, side);
    const FieldState state = StateOf(box);
    field.Put(std::move(box.mesh), state);
  }

  OptimizeOptions options;
  std::unique_ptr<TrainingRenderer> renderer;
  TrainingPictures pictures;
  BatchDrawer batches;
  FittedField field;
  VertexMotion motion;
  TrainingSteps steps;
};

}  // namespace tetrec
