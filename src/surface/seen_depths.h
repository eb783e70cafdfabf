// Where the rays of the training cameras are stopped in a field: where they have lost a third of
// their light.
#pragma once

#include "field/radiance_field.h"
#include "render/renderer.h"
#include "surface/opacity_level.h"

#include <filesystem>
#include <vector>

namespace tetrec {

// One for each training view of the scene, from the camera that the run corrected if the field's
// folder has corrections. Throws DataError for the scene's files, EnvironmentError without Vulkan.
std::vector<SeenDepth> RenderSeenDepths(const RadianceField& field,
                                        const std::filesystem::path& scene_folder,
                                        const std::filesystem::path& field_folder,
                                        const DeviceOptions& device);

}  // namespace tetrec
