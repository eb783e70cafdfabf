// The memory that a field takes on a device, and what the device has.
#include "render/vulkan/device_memory.h"

#include "render/vulkan/device_field.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {

uint64_t FieldBytes(const TetMesh& mesh, const FieldLayout& layout, bool fixed_point,
                    size_t views_per_batch) {
  uint64_t faces = 0;
  for (const glm::uvec4& neighbors : mesh.neighbors) {
    for (int i = 0; i < 4; ++i) faces += neighbors[i] == kNoTet;
  }
  const DeviceFieldBytes bytes = BytesOf(layout, fixed_point, views_per_batch);
  return mesh.tets.size() * bytes.of_tet + mesh.positions.size() * bytes.of_vertex +
         faces * bytes.of_face;
}

FreeMemory MeasureFreeMemory(const Device& device) {
  if (device.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) {
    return MeasureFreeHostMemory();
  }
  uint64_t largest = 0;  // of its own heaps: it reaches the host's, too, but far more slowly
  for (uint32_t i = 0; i < device.memory.memoryHeapCount; ++i) {
    const VkMemoryHeap& heap = device.memory.memoryHeaps[i];
    if ((heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) == 0) continue;
    largest = std::max<uint64_t>(largest, heap.size);
  }
  return {largest, fmt::format("device '{}'", device.properties.deviceName)};
}

}  // namespace tetrec
