// A Vulkan device with one queue for compute and, if possible, graphics.
#include "gpu/device.h"

#include "core/error.h"
#include "core/log.h"
#include "gpu/staging.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstring>

namespace tetrec {
namespace {

const char* ResultName(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_DEVICE_LOST:
      return "device lost";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialization failed";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no compatible driver";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "feature not present";
    default:
      return "error";
  }
}

VKAPI_ATTR VkBool32 VKAPI_CALL OnValidationMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                   VkDebugUtilsMessageTypeFlagsEXT,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data,
                                                   void* user) {
  static_cast<Device*>(user)->validation_messages.emplace_back(data->pMessage);
  LogWarning("Vulkan validation: {}", data->pMessage);
  return VK_FALSE;
}

const char* TypeName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "software";
    default:
      return "other";
  }
}

// Lower is preferred by "auto".
int Rank(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 0;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 1;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return 3;
    default:
      return 4;
  }
}

VkInstance CreateInstance(const DeviceOptions& options, Device* device) {
  VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                .pApplicationName = "tetrec",
                                .apiVersion = VK_API_VERSION_1_3};
  VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                            .pApplicationInfo = &application};
  const char* layer = "VK_LAYER_KHRONOS_validation";
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                   .enabledValidationFeatureCount = 1,
                                   .pEnabledValidationFeatures = enabled};
  if (options.validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &layer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance);
  if (result == VK_ERROR_LAYER_NOT_PRESENT) {
    throw EnvironmentError(
        "Vulkan validation layer is missing: apt-get install vulkan-validationlayers");
  }
  if (result != VK_SUCCESS) {
    throw EnvironmentError(fmt::format(
        "no Vulkan driver ({}): apt-get install mesa-vulkan-drivers gives a software device",
        ResultName(result)));
  }
  if (options.validation) {
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
    VkDebugUtilsMessengerCreateInfoEXT messenger{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = OnValidationMessage,
        .pUserData = device};
    TETREC_VK(create(instance, &messenger, nullptr, &device->messenger));
  }
  return instance;
}

std::vector<VkPhysicalDevice> PhysicalDevices(VkInstance instance) {
  uint32_t count = 0;
  TETREC_VK(vkEnumeratePhysicalDevices(instance, &count, nullptr));
  std::vector<VkPhysicalDevice> devices(count);
  if (count > 0) TETREC_VK(vkEnumeratePhysicalDevices(instance, &count, devices.data()));
  return devices;
}

VkPhysicalDeviceProperties PropertiesOf(VkPhysicalDevice device) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(device, &properties);
  return properties;
}

bool HasExtension(VkPhysicalDevice device, const char* name) {
  uint32_t count = 0;
  TETREC_VK(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> extensions(count);
  TETREC_VK(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()));
  return std::any_of(extensions.begin(), extensions.end(), [name](const VkExtensionProperties& e) {
    return std::strcmp(e.extensionName, name) == 0;
  });
}

// What a device lacks, as the end of a sentence about it; empty if it is suitable.
std::string LackOf(VkPhysicalDevice device) {
  const uint32_t version = PropertiesOf(device).apiVersion;
  if (version < VK_API_VERSION_1_3) {
    return fmt::format("has API {}.{}, and 1.3 is needed", VK_API_VERSION_MAJOR(version),
                       VK_API_VERSION_MINOR(version));
  }
  if (!HasExtension(device, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME)) {
    return "lacks VK_KHR_push_descriptor";
  }
  return {};
}

VkPhysicalDevice ChooseDevice(VkInstance instance, const std::string& wish) {
  const std::vector<VkPhysicalDevice> devices = PhysicalDevices(instance);
  if (devices.empty()) {
    throw EnvironmentError(
        "no Vulkan device: apt-get install mesa-vulkan-drivers gives a software device");
  }
  if (!wish.empty() && std::all_of(wish.begin(), wish.end(), ::isdigit)) {
    const size_t number = wish.size() > 6 ? devices.size() : std::stoul(wish);
    if (number < devices.size()) return devices[number];
    std::vector<std::string> known;
    for (const VkPhysicalDevice device : devices) {
      known.push_back(fmt::format("{} ({})", known.size(), PropertiesOf(device).deviceName));
    }
    throw EnvironmentError(
        fmt::format("no Vulkan device {}: choose {}, or 'auto'", wish, fmt::join(known, ", ")));
  }
  if (wish != "auto" && wish != "cpu" && wish != "gpu") {
    throw UsageError(fmt::format("device '{}': expected auto, cpu, gpu or a number", wish));
  }
  VkPhysicalDevice best = VK_NULL_HANDLE;
  int best_rank = 5;
  for (VkPhysicalDevice candidate : devices) {
    const VkPhysicalDeviceType type = PropertiesOf(candidate).deviceType;
    const bool is_software = type == VK_PHYSICAL_DEVICE_TYPE_CPU;
    if ((wish == "cpu" && !is_software) || (wish == "gpu" && is_software)) continue;
    if (Rank(type) >= best_rank) continue;
    if (const std::string lack = LackOf(candidate); !lack.empty()) {
      LogInfo("the Vulkan device '{}' {}: it is not used", PropertiesOf(candidate).deviceName,
              lack);
      continue;
    }
    best_rank = Rank(type);
    best = candidate;
  }
  if (best == VK_NULL_HANDLE) {
    throw EnvironmentError(
        fmt::format("no suitable Vulkan device of kind '{}': choose the device 'auto', or "
                    "apt-get install mesa-vulkan-drivers for a software device",
                    wish));
  }
  return best;
}

// The family that computes; one that draws too is preferred.
uint32_t ChooseQueueFamily(VkPhysicalDevice device, bool& has_graphics) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  constexpr VkQueueFlags kBoth = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT;
  for (VkQueueFlags wanted : {kBoth, VkQueueFlags(VK_QUEUE_COMPUTE_BIT)}) {
    for (uint32_t i = 0; i < count; ++i) {
      if ((families[i].queueFlags & wanted) != wanted) continue;
      has_graphics = wanted == kBoth;
      return i;
    }
  }
  throw EnvironmentError("the Vulkan device has no compute queue: choose another device");
}

uint32_t TimestampBits(VkPhysicalDevice device, uint32_t family) {
  uint32_t count = family + 1;
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  return families[family].timestampValidBits;
}

bool AddsFloatsAtomically(VkPhysicalDevice device) {
  if (!HasExtension(device, VK_EXT_SHADER_ATOMIC_FLOAT_EXTENSION_NAME)) return false;
  VkPhysicalDeviceShaderAtomicFloatFeaturesEXT atomics{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_FLOAT_FEATURES_EXT};
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                     .pNext = &atomics};
  vkGetPhysicalDeviceFeatures2(device, &features);
  return atomics.shaderBufferFloat32AtomicAdd == VK_TRUE;
}

// The features that Device::has_raster and has_int64_atomics need.
struct CoreFeatures {
  bool raster, int64_atomics;
};

CoreFeatures QueryFeatures(VkPhysicalDevice device) {
  VkPhysicalDeviceVulkan13Features features13{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceVulkan12Features features12{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &features13};
  VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                     .pNext = &features12};
  vkGetPhysicalDeviceFeatures2(device, &features);
  return {
      features13.dynamicRendering == VK_TRUE &&
          features.features.fragmentStoresAndAtomics == VK_TRUE,
      features.features.shaderInt64 == VK_TRUE && features12.shaderBufferInt64Atomics == VK_TRUE};
}

void CreateLogicalDevice(Device& device) {
  if (const std::string lack = LackOf(device.physical); !lack.empty()) {
    throw EnvironmentError(fmt::format("the Vulkan device '{}' {}: choose another one, or 'auto'",
                                       device.properties.deviceName, lack));
  }
  std::vector<const char*> extensions = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
  VkPhysicalDeviceShaderAtomicFloatFeaturesEXT atomics{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_FLOAT_FEATURES_EXT,
      .shaderBufferFloat32AtomicAdd = VK_TRUE};
  VkPhysicalDeviceVulkan13Features features13{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
      .synchronization2 = VK_TRUE,
      .dynamicRendering = device.has_raster,
      .maintenance4 = VK_TRUE};  // LocalSizeId, which the shader compiler emits for Vulkan 1.3
  if (device.has_float_atomics) {
    extensions.push_back(VK_EXT_SHADER_ATOMIC_FLOAT_EXTENSION_NAME);
    features13.pNext = &atomics;
  }
  VkPhysicalDeviceVulkan12Features features12{
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
      .pNext = &features13,
      .shaderBufferInt64Atomics = device.has_int64_atomics};
  const VkPhysicalDeviceFeatures features{.fragmentStoresAndAtomics = device.has_raster,
                                          .shaderInt64 = device.has_int64_atomics};
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                .queueFamilyIndex = device.queue_family,
                                .queueCount = 1,
                                .pQueuePriorities = &priority};
  VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                          .pNext = &features12,
                          .queueCreateInfoCount = 1,
                          .pQueueCreateInfos = &queue,
                          .enabledExtensionCount = uint32_t(extensions.size()),
                          .ppEnabledExtensionNames = extensions.data(),
                          .pEnabledFeatures = &features};
  TETREC_VK(vkCreateDevice(device.physical, &info, nullptr, &device.handle));
  vkGetDeviceQueue(device.handle, device.queue_family, 0, &device.queue);
  device.push_descriptor_set = reinterpret_cast<PFN_vkCmdPushDescriptorSetKHR>(
      vkGetDeviceProcAddr(device.handle, "vkCmdPushDescriptorSetKHR"));
}

// Without memory, drivers crash instead of reporting it. On two threads, Mesa's lavapipe crashed
// now and then below 780 MiB of address space, even for the smallest field.
void CheckAddressSpace() {
  constexpr rlim_t kLeast_MiB = 1024;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur >= kLeast_MiB << 20) return;
  throw EnvironmentError(fmt::format(
      "the address space is limited to {} MiB, and Vulkan drivers may crash with less than {} MiB; "
      "raise the limit (ulimit -v)",
      limit.rlim_cur >> 20, kLeast_MiB));
}

}  // namespace

void CheckVulkan(VkResult result, const char* call) {
  if (result == VK_SUCCESS) return;
  const std::string message =
      fmt::format("Vulkan: {} ({}) in {}", ResultName(result), int(result), call);
  switch (result) {
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      throw EnvironmentError(message + "; use smaller pictures or a smaller mesh");
    case VK_ERROR_INITIALIZATION_FAILED:  // also where a driver gets no memory or threads
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      throw EnvironmentError(message +
                             "; the driver does not start: it is not installed completely, or the "
                             "limits on memory and threads are too low for it (ulimit -a)");
    case VK_ERROR_DEVICE_LOST:
      throw EnvironmentError(message);
    default:
      break;
  }
  throw BugError(message);
}

Device::Device() = default;

Device::~Device() {
  staging.reset();
  if (handle != VK_NULL_HANDLE) {
    vkDeviceWaitIdle(handle);
    vkDestroyCommandPool(handle, command_pool, nullptr);
    vkDestroyDevice(handle, nullptr);
  }
  if (messenger != VK_NULL_HANDLE) {
    reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(
        instance, "vkDestroyDebugUtilsMessengerEXT"))(instance, messenger, nullptr);
  }
  if (instance != VK_NULL_HANDLE) vkDestroyInstance(instance, nullptr);
}

std::unique_ptr<Device> CreateDevice(const DeviceOptions& options) {
  CheckAddressSpace();
  auto device = std::make_unique<Device>();
  device->instance = CreateInstance(options, device.get());
  device->physical = ChooseDevice(device->instance, options.device);
  VkPhysicalDeviceDriverProperties driver{.sType =
                                              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                         .pNext = &driver};
  vkGetPhysicalDeviceProperties2(device->physical, &properties);
  device->properties = properties.properties;
  device->driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  vkGetPhysicalDeviceMemoryProperties(device->physical, &device->memory);
  bool has_graphics = false;
  device->queue_family = ChooseQueueFamily(device->physical, has_graphics);
  CoreFeatures features{};
  if (device->properties.apiVersion >= VK_API_VERSION_1_3) {
    features = QueryFeatures(device->physical);
  }
  device->maps_buffers = options.maps_buffers;
  device->has_raster = has_graphics && features.raster;
  device->has_float_atomics = options.float_atomics && AddsFloatsAtomically(device->physical);
  if (options.int64_atomics) {
    device->has_int64_atomics = features.int64_atomics;
    if (!device->has_int64_atomics) {
      throw EnvironmentError(fmt::format(
          "Vulkan device '{}' lacks 64-bit integer atomics (shaderInt64, "
          "shaderBufferInt64Atomics), which deterministic sums need: choose another device or do "
          "without determinism",
          device->properties.deviceName));
    }
  }
  CreateLogicalDevice(*device);
  device->timestamp_bits = TimestampBits(device->physical, device->queue_family);
  if (options.time_kernels && device->timestamp_bits > 0) {
    device->kernel_times = std::make_unique<KernelTimes>();
  }
  VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                               .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                               .queueFamilyIndex = device->queue_family};
  TETREC_VK(vkCreateCommandPool(device->handle, &pool, nullptr, &device->command_pool));
  return device;
}

uint32_t MostLoopRounds(const Device& device) {
  const bool software = device.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  return software ? 65535 : UINT32_MAX;
}

nlohmann::json DescribeDevice(const Device& device) {
  return {{"name", device.properties.deviceName},
          {"type", TypeName(device.properties.deviceType)},
          {"api", fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(device.properties.apiVersion),
                              VK_API_VERSION_MINOR(device.properties.apiVersion),
                              VK_API_VERSION_PATCH(device.properties.apiVersion))},
          {"driver", device.driver},
          {"float_atomics", device.has_float_atomics}};
}

}  // namespace tetrec
