// What differs between the Vulkan renderers: what they are given.
#include "render/vulkan/integrator.h"

#include <cmath>

namespace tetrec {

RayPass MakePass(DeviceField& field, RayBatch& rays, const Buffer& views,
                 std::span<const RayBlock> blocks, const gpu_types::GpuView& view,
                 const Buffer& counters, float stop_transmittance, const FixedPoint& fixed) {
  return {field,
          rays,
          views,
          blocks,
          view,
          counters,
          gpu_types::RayPush{.ray_count = rays.count,
                             .stop_depth = -std::log(stop_transmittance),
                             .color_quanta = fixed.color_quanta,
                             .density_quanta = fixed.density_quanta,
                             .position_quanta = fixed.position_quanta,
                             .largest_quanta = fixed.largest_quanta,
                             .first_cell = field.first_cell}};
}

}  // namespace tetrec
