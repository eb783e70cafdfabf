// The optimisation of a radiance field against the pictures of a scene.
#pragma once

#include "core/stage.h"
#include "optimize/schedule.h"
#include "render/renderer.h"
#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace tetrec {

struct OptimizeOptions {
  double time_limit_s = 300;  // of optimisation, refinement and watching included; 0: none
  uint64_t iterations = 0;    // 0: by time
  uint64_t seed = 1;
  int rays_per_step = 4096;
  LossOptions loss;
  double color_rate = 0.02;   // Adam's first step on colour [display sRGB]
  double density_rate = 0.2;  // on the logarithm of density
  double max_density = 1e5;   // [1 / world unit]
  // Pull of seen vertices towards empty, as a share of Adam's largest step: without it, photos of
  // different exposure are explained by fog before their cameras.
  double density_decay = 0.05;
  double jitter_px = 0.5;         // rays are moved inside their pixel by up to half of this
  double subject_share = 0.85;    // of the rays that are drawn where the masks show something
  bool random_background = true;  // behind field and target; false: the scene's own
  uint64_t max_vertices = 0;      // 0: what the time affords
  double score_rays_per_tet = 1;  // of a refinement's look at the errors
  int watched_views = 4;          // held-out views whose PSNR goes into metrics.csv
  double checkpoint_interval_s = 30;
  FieldStorage storage = FieldStorage::kVertex;  // of the field that is fitted
  ScheduleOptions schedule;
  RendererOptions renderer;

  void Check() const;  // throws UsageError naming the option and its value
};

// Reads the start field of the tetrahedralize stage and the scene before it; writes field.tetf,
// world.json (where the world lies in the input's coordinates) and metrics.csv (iteration, seconds,
// rays, loss, train_psnr, heldout_psnr, tets, vertices, phase; a row each 2 % of the run).
void RunOptimize(const OptimizeOptions& options, Stage& stage);

// Mean over the views of the PSNR of 8-bit pictures, RGB over the background, 4 rays a pixel.
double WatchPsnr(Renderer& renderer, const std::filesystem::path& scene_folder, const Scene& scene,
                 std::span<const int> views);

}  // namespace tetrec
