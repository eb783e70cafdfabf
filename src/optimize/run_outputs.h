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

// Writes exposure.json from one exposure per training view, without the photos that are left out;
// writes nothing if there are no exposures. Warns where photos differ much.
void WriteExposures(const Scene& scene, std::span<const ViewExposure> exposures,
                    std::span<const uint8_t> left_out, Stage& stage);

// Writes cameras.json from one pose and one given camera per training view, without the photos that
// are left out; writes nothing if there are no poses. Warns where cameras moved much.
void WriteCorrections(const Scene& scene, std::span<const RenderView> given,
                      std::span<const CorrectedPose> poses, std::span<const uint8_t> left_out,
                      Stage& stage);

// Writes left_out.json from one flag per training view; writes nothing if none is set. Warns of the
// photos that are left out.
void WriteLeftOut(const Scene& scene, std::span<const uint8_t> left_out, Stage& stage);

// world.json.
void WriteWorld(const Scene& scene, const std::filesystem::path& scene_folder, Stage& stage);

}  // namespace tetrec
