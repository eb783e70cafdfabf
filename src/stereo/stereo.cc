// Depth maps and a dense cloud of points from the training photos of a scene.
#include "stereo/stereo.h"

#include "core/log.h"
#include "core/option_range.h"
#include "core/parallel.h"
#include "stereo/consistency.h"
#include "stereo/neighbors.h"
#include "stereo/plane_sweep.h"
#include "stereo/slanted_planes.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr const char* kNothingKept = "nothing of this stage is kept";

// The first `count` of each list.
std::vector<std::vector<uint32_t>> FirstOf(std::span<const std::vector<uint32_t>> lists,
                                           size_t count) {
  std::vector<std::vector<uint32_t>> first;
  for (const std::vector<uint32_t>& list : lists) {
    first.emplace_back(list.begin(), list.begin() + std::ptrdiff_t(std::min(count, list.size())));
  }
  return first;
}

// What a view is matched with, and between which depths.
struct MatchedView {
  std::vector<const StereoView*> neighbors;
  DepthRange range;
};

// An empty map if the view cannot be matched.
StereoDepth MatchView(const StereoView& view, const MatchedView& with,
                      const StereoOptions& options) {
  StereoDepth map = MakeStereoDepth(view.view, view.camera);
  if (with.neighbors.empty() || with.range.IsEmpty()) return map;
  const SweepPlanes planes =
      ChoosePlanes(view, with.neighbors, with.range, options.plane_step_px, options.max_planes);
  const CostVolume volume = SweepPlanesOf(view, with.neighbors, planes, options.window_radius);
  const PlaneChoice choice = ChooseSmoothPlanes(volume, view.grey, planes.count, options.smoothing);
  const double max_cost = options.max_cost * kLargestCost;
  for (size_t i = 0; i < map.depth.size(); ++i) {
    const bool is_good = view.kinds[i] == PixelKind::kSeen && choice.plane[i] >= 0 &&
                         double(choice.cost[i]) <= max_cost && choice.cost[i] != kUnknownCost;
    if (is_good) map.depth[i] = float(1 / planes.InverseDepth(choice.plane[i]));
  }
  return map;
}

// Fits the map once more, on slanted planes; an empty map stays empty.
void Slant(const StereoView& view, const MatchedView& with, const StereoOptions& options,
           StereoDepth& map) {
  if (CountDepths(map) == 0) return;
  std::vector<float> inverse_depths;
  for (const float depth : map.depth) inverse_depths.push_back(depth > 0 ? 1 / depth : 0.0f);
  FitSlantedPlanes(view, with.neighbors, with.range, options.slanted, inverse_depths);
  for (size_t i = 0; i < map.depth.size(); ++i) {
    map.depth[i] = inverse_depths[i] > 0 ? 1 / inverse_depths[i] : 0.0f;
  }
}

// The same patch has evidence in proportion to the map's pixels. `usual`: in a map of 400 x 300.
int LeastEvidence(const StereoDepth& map, int usual) {
  constexpr double kUsualPixels = 400 * 300;
  return std::max(1, int(std::lround(usual * double(map.depth.size()) / kUsualPixels)));
}

}  // namespace

void StereoOptions::Check() const {
  CheckRange("depth_size", max_size, 32, 4096);
  CheckRange("depth_neighbors", neighbors, 1, 32);
  CheckRange("checked_neighbors", checked_neighbors, 1, 1000);
  CheckAboveZero("tolerance", tolerance);
  CheckRange("evidence", evidence, 1, 1'000'000);
  CheckAboveZero("patch_tolerance", patch_tolerance);
  CheckAboveZero("plane_step", plane_step_px);
  CheckRange("max_planes", max_planes, 2, 1024);
  CheckRange("window_radius", window_radius, 1, 10);
  CheckRange("max_cost", max_cost, 0.0, 1.0);
  CheckRange("slant_below", slant_below, 0.0, 1.0);
  CheckRange("slanted_rounds", slanted.rounds, 1, 100);
  CheckRange("slanted_max_cost", slanted.max_cost, 0.0, 1.0);
  CheckRange<uint64_t>("dense_points", fusion.max_points, 0, 10'000'000);
}

StereoResult FindDepths(const Scene& scene, std::span<const StereoView> views,
                        const StereoOptions& options) {
  const std::vector<glm::dvec3> points = OverlapPoints(scene);
  const std::vector<std::vector<uint32_t>> checked = ChooseNeighbors(
      views, points, size_t(std::max(options.checked_neighbors, options.neighbors)));
  const std::vector<std::vector<uint32_t>> matched = FirstOf(checked, size_t(options.neighbors));

  std::vector<StereoDepth> maps(views.size());
  std::vector<MatchedView> with(views.size());
  ParallelForEach(views.size(), "depth maps", kNothingKept, [&](size_t i) {
    for (const uint32_t j : matched[i]) with[i].neighbors.push_back(&views[j]);
    with[i].range = FindDepthRange(views[i], points, scene);
    maps[i] = MatchView(views[i], with[i], options);
  });
  StereoResult result;
  result.maps = CountAgreement(maps, views, checked, options.tolerance);
  const double confirmed = ShareConfirmedByTwo(result.maps);
  result.is_slanted = confirmed < options.slant_below;
  if (result.is_slanted) {
    LogInfo("two other views confirm only {:.0f} % of the depths: fitting slanted planes",
            100 * confirmed);
    ParallelForEach(views.size(), "slanted planes", kNothingKept,
                    [&](size_t i) { Slant(views[i], with[i], options, maps[i]); });
    result.maps = CountAgreement(maps, views, checked, options.tolerance);
  }
  for (const StereoDepth& map : maps) {
    const uint64_t depths = CountDepths(map);
    result.pixels += map.depth.size();
    result.matched += depths;
    result.views_without += depths == 0 ? 1 : 0;
  }
  const int least_views = ViewsToConfirm(result.maps);
  for (StereoDepth& map : result.maps) {
    result.confirmed += KeepConfirmed(map, least_views, LeastEvidence(map, options.evidence),
                                      options.patch_tolerance);
  }
  result.fusion = FuseDepths(result.maps, views, options.fusion);
  return result;
}

}  // namespace tetrec
