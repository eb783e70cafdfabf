// Which Vulkan device to use and how; no Vulkan type in it.
#pragma once

#include <string>

namespace tetrec {

struct DeviceOptions {
  // "auto" (a GPU where there is one, else software), "cpu", "gpu", or a number of ListDevices.
  std::string device = "auto";
  bool validation = false;     // core and synchronization validation; messages are counted
  bool float_atomics = true;   // false: compare and swap even where the device adds floats natively
  bool time_kernels = false;   // by timestamps; nothing where the device has none
  bool int64_atomics = false;  // needed; a device without them is an EnvironmentError
};

}  // namespace tetrec
