// Depth maps and a dense cloud of points from the training photos of a scene.
#pragma once

#include "run/stereo_depth.h"
#include "scene/scene.h"
#include "stereo/fusion.h"
#include "stereo/semi_global.h"
#include "stereo/slanted_planes.h"
#include "stereo/stereo_view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

struct StereoOptions {
  int max_size = 400;             // longer side of the depth maps [px], at most the images' own
  int neighbors = 4;              // views that a view is matched with
  int checked_neighbors = 10;     // views that may confirm its depths
  double tolerance = 0.01;        // relative difference of inverse depths that agree
  int evidence = 200;             // of a patch of depths that is kept, in a map of 400 x 300 pixels
  double patch_tolerance = 0.03;  // relative difference of depths next to each other in a patch
  double plane_step_px = 1;       // largest move of a pixel in a neighbour from plane to plane
  int max_planes = 256;
  int window_radius = 2;  // of the windows that are compared [px]
  double max_cost = 0.6;  // of a chosen plane, before smoothing; 0 is a perfect match
  SemiGlobalOptions smoothing;
  // Where two other views confirm a smaller share of the depths than this, photos are far apart,
  // and depths are fitted once more, on slanted planes, which takes some seconds per view.
  double slant_below = 0.6;
  SlantedOptions slanted;
  FusionOptions fusion;

  void Check() const;  // throws UsageError naming the option and its value
};

struct StereoResult {
  std::vector<StereoDepth> maps;  // one per training view; depths of KeepConfirmed
  Fusion fusion;                  // DensePoint::views index `maps`
  uint64_t pixels = 0;            // of all maps
  uint64_t matched = 0;           // depths before other views were asked
  uint64_t confirmed = 0;         // depths in `maps`
  bool is_slanted = false;        // depths are of slanted planes
  uint64_t views_without = 0;     // views that share too little with others to be matched
};

// Uses training views only.
StereoResult FindDepths(const Scene& scene, std::span<const StereoView> views,
                        const StereoOptions& options);

}  // namespace tetrec
