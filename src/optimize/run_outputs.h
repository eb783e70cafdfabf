// What a run writes beside the field: how the photos were exposed, which were left out, how the
// cameras were corrected, and where the world is.
#pragma once

#include "core/stage.h"
#include "optimize/camera_poses.h"
#include "render/exposure.h"
#include "render/renderer.h"
#include "scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <span>

namespace tetrec {

// exposure.json, one per training view; nothing is written if there are none. Warns where photos
// differ much.
void WriteExposures(const Scene& scene, std::span<const ViewExposure> exposures, Stage& stage);

// cameras.json, by a pose and a given camera per training view, without those that are left out;
// nothing is written if there are no poses. Warns where cameras moved much.
void WriteCorrections(const Scene& scene, std::span<const RenderView> given,
                      std::span<const CorrectedPose> poses, std::span<const uint8_t> left_out,
                      Stage& stage);

// left_out.json, by a flag per training view; nothing is written if none is set. Warns of them.
void WriteLeftOut(const Scene& scene, std::span<const uint8_t> left_out, Stage& stage);

// world.json.
void WriteWorld(const Scene& scene, const std::filesystem::path& scene_folder, Stage& stage);

}  // namespace tetrec
