// Where the rays of the training cameras are stopped in a field: where they have lost a third of
// their light, or more of it if there is haze in front of the surfaces, or where depth maps of the
// photos show a surface meanwhile.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "render/training_renderer.h"
#include "surface/opacity_level.h"
#include "surface/passing_rays.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// The optical depth at which rays are stopped: the least of four (0.4 to 2) at which no more than a
// quarter of these views' rays end far in front of the place where they have lost 86 % of their
// light. Only rays for which that place is inside the subject's bounds count. Photos taken in one
// direction can be explained by haze in front of surfaces whose colours have too much contrast.
double FindSurfaceDepth(TrainingRenderer& renderer, std::span<const RenderView> views,
                        const Bounds3& subject_in_world);

struct SeenDepths {
  std::vector<SeenDepth> views;
  double optical_depth = 0;  // at which rays are stopped
  // The rays of all views, and those whose depths are confirmed ones (UseConfirmedDepths).
  uint64_t rays = 0, confirmed_rays = 0;
  PassingRays passing_rays;
  nlohmann::json device;  // that rendered them
};

// One for each training view of the scene, from the camera that the run corrected if the field's
// folder has corrections, with the depths that photos confirm if the start was dense. Rays that
// pass through walls are mended (MendPassingRays); `bounds_in_world` are those of the surface.
// Throws DataError for the files of the scene and of the start, EnvironmentError without Vulkan.
SeenDepths RenderSeenDepths(const RadianceField& field, const std::filesystem::path& scene_folder,
                            const std::filesystem::path& field_folder,
                            const Bounds3& bounds_in_world, const DeviceOptions& device);

}  // namespace tetrec
