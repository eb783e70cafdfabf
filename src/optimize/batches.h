// The batches of rays that training steps draw.
#pragma once

#include "optimize/optimize_options.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <filesystem>
#include <span>

namespace tetrec {

// A batch depends on the seed, the iteration and the rays per pixel alone, so a resumed run draws
// what the first one would have drawn.
class BatchDrawer {
 public:
  // For `renderer`. `background_srgb`: the scene's own. Throws DataError that names `scene_folder`
  // if an image is too small for the loss.
  BatchDrawer(const OptimizeOptions& options, const TrainingSet& set,
              const TrainingRenderer& renderer, const glm::vec3& background_srgb,
              const std::filesystem::path& scene_folder);

  // Its blocks stay valid until the next call. `samples`: TrainingBatch::samples, 1 if
  // DrawsTiles.
  TrainingBatch Draw(uint64_t iteration, int samples = 1);
  int rays_per_step() const { return options_.RaysPerStep(pace_); }
  // If `few`, each batch draws its rays from at most as many views as the device's pace has.
  void UseFewViews(bool few) { few_views_ = few; }
  bool few_views() const { return few_views_; }
  // How many blocks, from the first on, make one batch: at most `most`, and of few views if
  // UseFewViews. Blocks are sorted by view.
  size_t CountOfBatch(std::span<const RayBlock> blocks, size_t most) const;
  // Behind field and targets: random, or the scene's own if that is chosen. By
  // BackgroundChoice::kAuto, TrainingSteps takes the latter for pictures with alpha, but looks at
  // errors do not: they have no part for opacity, whose errors they see by random colours only.
  glm::vec3 Background(uint64_t iteration) const;
  const glm::vec3& background_of_scene_srgb() const { return background_srgb_; }

  // Whether the loss or the renderer needs tiles, which have one ray per pixel.
  bool DrawsTiles() const { return needs_tiles_ || options_.loss.dssim > 0; }

 private:
  TileShape DrawBlocksOrTiles(uint64_t iteration);
  void RefineBlocks(uint64_t iteration, int samples);

  const OptimizeOptions& options_;
  const TrainingSet& set_;
  DevicePace pace_;
  bool needs_tiles_, few_views_ = false;
  glm::vec3 background_srgb_;
  std::vector<RayBlock> blocks_;
};

}  // namespace tetrec
