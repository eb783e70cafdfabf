// A Vulkan device with one queue for compute and, if possible, graphics.
#pragma once

#include "gpu/device_options.h"
#include "gpu/kernel_times.h"

#include <nlohmann/json.hpp>
#include <vulkan/vulkan.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tetrec {

// Memory that a device's buffers take.
struct MemoryUse {
  uint64_t bytes = 0, most_bytes = 0;  // now, and the maximum since the device was made
};

class StagingArea;

struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice handle = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t queue_family = 0;
  VkCommandPool command_pool = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::string driver;
  bool has_float_atomics = false;
  bool has_int64_atomics = false;  // on storage buffers
  bool has_raster = false;         // can draw without attachments, its fragments writing to buffers
  PFN_vkCmdPushDescriptorSetKHR push_descriptor_set = nullptr;
  std::vector<std::string> validation_messages;  // empty means clean
  const std::unique_ptr<MemoryUse> memory_use = std::make_unique<MemoryUse>();
  std::unique_ptr<KernelTimes> kernel_times;     // null unless requested and possible
  uint32_t timestamp_bits = 0;                   // valid bits; 0: the queue has no timestamps
  bool maps_buffers = true;                      // DeviceOptions::maps_buffers
  mutable std::unique_ptr<StagingArea> staging;  // of StagingOf (staging.h)

  Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();
};

// Throws EnvironmentError if there is no Vulkan loader or driver or no such device, or if a feature
// is missing, which it names; UsageError if `options.device` has no meaning.
std::unique_ptr<Device> CreateDevice(const DeviceOptions& options);

// Rounds that all loops of one kernel invocation may run together, nested ones included. Beyond
// that llvmpipe silently ends them, and results are wrong.
uint32_t MostLoopRounds(const Device& device);

// Name, type, API version and driver, for the manifest.
nlohmann::json DescribeDevice(const Device& device);

// Throws EnvironmentError (out of memory, device lost) or BugError with the call and the name of
// the result.
void CheckVulkan(VkResult result, const char* call);
#define TETREC_VK(call) ::tetrec::CheckVulkan((call), #call)

}  // namespace tetrec
