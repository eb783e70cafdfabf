// What keeps a Vulkan device busy.
#pragma once

#include "gpu/device.h"
#include "render/device_pace.h"

namespace tetrec {

// On an H100, a step of 65,536 rays takes 1.4 times as long as one of 4,096, which leaves most of
// the device idle, and it takes some hundred times as many rays per second as two cores. Nothing
// is known of the GPU at hand, so a run counts on a part of that. With a motion in every 16 steps,
// the host's part of the motions took 115 s of a run of 300 s with 289 thousand vertices.
inline DevicePace PaceOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return {};
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return {.rays_per_step = 16384, .views_per_batch = 8, .speed = 4, .steps_per_motion = 32};
    default:
      return {.rays_per_step = 65536, .views_per_batch = 16, .speed = 10, .steps_per_motion = 64};
  }
}
inline DevicePace PaceOf(const Device& device) { return PaceOf(device.properties.deviceType); }

}  // namespace tetrec
