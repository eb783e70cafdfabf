// Where the rays of the training cameras are stopped in a field.
#include "surface/seen_depths.h"

#include "core/manifest.h"
#include "core/progress.h"
#include "core/spread_choice.h"
#include "core/stop_request.h"
#include "mesh/tet_mesh.h"
#include "render/create_renderer.h"
#include "run/stereo_depth.h"
#include "scene/scene.h"
#include "surface/confirmed_depths.h"
#include "surface/trained_views.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

// Optical depths at which a surface may lie. At half of the light, 0.69, the demo's surface lies
// 0.17 % of its diagonal too deep in the median, because the colour of what lies behind a soft
// surface is the same; at 0.35 its table, which many rays meet at a flat angle, lies too high. The
// others are for haze; at the last, 14 % of the light is left.
constexpr std::array kSurfaceDepths = {0.4, 0.8, 1.2, 2.0};
// A ray is stopped far in front of a surface if it falls short of it by more than this share of its
// depth. At outlines and in leaves some rays do so without any haze; more than this share do not.
constexpr double kFarInFront = 0.05, kMostFarInFront = 0.25;
// The number of training views whose rays decide which optical depth is used.
constexpr size_t kDecidingViews = 5;

// Of the rays that are stopped inside the bounds in `solid`, the share that is stopped far in front
// of that in `maps`.
double ShareFarInFront(std::span<const DepthMap> maps, std::span<const DepthMap> solid,
                       std::span<const RenderView> views, const Bounds3& bounds) {
  size_t far = 0, all = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const Rigid3 world_from_cam = views[v].cam_from_world.Inverse();
    for (int y = 0; y < solid[v].height; ++y) {
      for (int x = 0; x < solid[v].width; ++x) {
        if (solid[v].At(x, y) == kNoDepth) continue;
        const double depth = double(solid[v].At(x, y));
        const glm::dvec3 in_cam = depth * views[v].camera.CamFromImage({x + 0.5, y + 0.5});
        if (!bounds.Contains(world_from_cam * in_cam)) continue;
        ++all;
        far += double(maps[v].At(x, y)) < (1 - kFarInFront) * depth;
      }
    }
  }
  return all == 0 ? 0.0 : double(far) / double(all);
}

}  // namespace

double FindSurfaceDepth(TrainingRenderer& renderer, std::span<const RenderView> views,
                        const Bounds3& subject_in_world) {
  const auto maps_at = [&](double optical_depth) {
    std::vector<DepthMap> maps;
    for (const RenderView& view : views) {
      ThrowIfStopRequested(kAfterASurfaceStop);
      maps.push_back(renderer.RenderDepth(view, optical_depth));
    }
    return maps;
  };
  const std::vector<DepthMap> solid = maps_at(kSurfaceDepths.back());
  return *std::ranges::find_if(kSurfaceDepths, [&](double depth) {
    return depth == kSurfaceDepths.back() ||
           ShareFarInFront(maps_at(depth), solid, views, subject_in_world) <= kMostFarInFront;
  });
}

SeenDepths RenderSeenDepths(const RadianceField& field, const fs::path& scene_folder,
                            const fs::path& field_folder, const Bounds3& bounds_in_world,
                            const DeviceOptions& device) {
  const Scene scene = ReadScene(scene_folder);
  RendererOptions options;
  options.device = device;
  if (CountDegenerateTets(field.mesh) > 0) options.AcceptInvertedTets();
  const std::unique_ptr<TrainingRenderer> renderer = CreateRenderer(options);
  renderer->SetField(field);
  const std::vector<TrainedView> trained = TrainedViews(scene, field_folder);
  std::vector<RenderView> views;
  for (const TrainedView& view : trained) views.push_back({view.camera, view.cam_from_world});
  const fs::path start_folder = PreviousStage(field_folder, {"tetrahedralize"});
  SeenDepths seen;
  seen.device = renderer->DescribeDevice();
  seen.optical_depth = FindSurfaceDepth(*renderer, SpreadChoice<RenderView>(views, kDecidingViews),
                                        scene.subject_bounds);
  Progress progress("depth", double(views.size()));
  for (size_t v = 0; v < views.size(); ++v) {
    ThrowIfStopRequested(kAfterASurfaceStop);
    const DepthMap level = renderer->RenderDepth(views[v], seen.optical_depth);
    const auto stopped_at = [&](double optical_depth) {
      return optical_depth == seen.optical_depth ? level
                                                 : renderer->RenderDepth(views[v], optical_depth);
    };
    const DepthMap first = stopped_at(kSurfaceDepths.front());
    SeenDepth view{views[v].camera, views[v].cam_from_world, level, {}};
    seen.rays += level.depth.size();
    if (const auto map = FindStereoDepth(start_folder, trained[v].index)) {
      const LossOfLight loss{first, stopped_at(kSurfaceDepths.back())};
      seen.confirmed_rays += UseConfirmedDepths(view.camera, *map, loss, view.depth);
    }
    // At the first level, no ray has lost some of its light without being stopped.
    if (seen.optical_depth > kSurfaceDepths.front()) {
      seen.passing_rays +=
          MendPassingRays(bounds_in_world, {first, stopped_at(kSurfaceDepths[1]), level}, view);
    }
    seen.views.push_back(std::move(view));
    progress.Update(double(v + 1), trained[v].name);
  }
  return seen;
}

}  // namespace tetrec
