// Which Vulkan device to use and how, without Vulkan types.
#pragma once

#include <string>

namespace tetrec {

struct DeviceOptions {
  // "auto" (a GPU if there is one, otherwise software), "cpu", "gpu", or a number: Vulkan's order,
  // from 0. The error for a number that is too high names them all.
  std::string device = "auto";
  bool validation = false;    // core and synchronization validation; messages are collected
  bool float_atomics = true;  // false: compare-and-swap even if the device adds floats natively
  bool time_kernels = false;  // by timestamps, if the device has them
  // False, for tests: buffers of the device are reached by copies, as if its memory were its own.
  bool maps_buffers = true;
  bool int64_atomics = false;  // required: a device without them is an EnvironmentError
};

}  // namespace tetrec
