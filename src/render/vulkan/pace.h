// What keeps a Vulkan device busy.
#pragma once

#include "gpu/device.h"
#include "render/device_pace.h"

namespace tetrec {

// On an H100, the march of 65,536 rays, forward and backward, takes 1.4 times as long as that of
// 4,096, which leaves most of the device idle, and steps take some hundred times as many rays per
// second as on two cores. Nothing is known of the GPU at hand, so a run counts on a part of that.
// With a motion in every 16 steps, the host's part of the motions took 115 s of a run of 300 s with
// 289 thousand vertices.
inline DevicePace PaceOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return {.rays_per_step = 65536, .views_per_batch = 16, .speed = 10, .steps_per_motion = 64};
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:  // a part of a GPU
      return {.rays_per_step = 16384, .views_per_batch = 8, .speed = 4, .steps_per_motion = 32};
    default:
      return {};
  }
}
inline DevicePace PaceOf(const Device& device) { return PaceOf(device.properties.deviceType); }

}  // namespace tetrec
