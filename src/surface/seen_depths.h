// Where the rays of the training cameras are stopped in a field: where they have lost a third of
// their light or, if that is in haze before what is solid, more of it.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "render/training_renderer.h"
#include "surface/opacity_level.h"

#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// The optical depth by which the rays of these views have come to what is solid: the least of some
// by which at most a quarter of the rays are far in front of where they have lost most of their
// light, of those that lose it inside the subject's bounds. Photos in one direction are explained
// as well by haze in front of colours of more contrast.
double FindSurfaceDepth(TrainingRenderer& renderer, std::span<const RenderView> views,
                        const Bounds3& subject_in_world);

struct SeenDepths {
  std::vector<SeenDepth> views;
  double optical_depth = 0;  // at which rays are stopped
};

// One for each training view of the scene, from the camera that the run corrected if the field's
// folder has corrections. Throws DataError for the scene's files, EnvironmentError without Vulkan.
SeenDepths RenderSeenDepths(const RadianceField& field, const std::filesystem::path& scene_folder,
                            const std::filesystem::path& field_folder, const DeviceOptions& device);

}  // namespace tetrec
