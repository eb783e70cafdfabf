// A Vulkan device with validation for tests; a message of the layer fails the test that caused it.
#pragma once

#include "core/error.h"
#include "gpu/device.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tetrec::test {

class VulkanTest : public ::testing::Test {
 protected:
  VulkanTest() = default;
  explicit VulkanTest(DeviceOptions options) : options_(std::move(options)) {}

  void SetUp() override {
    options_.validation = true;
    try {
      device_ = CreateDevice(options_);
    } catch (const EnvironmentError& error) {
      GTEST_SKIP() << error.what();
    }
  }
  void TearDown() override {
    if (device_) {
      EXPECT_EQ(device_->validation_messages, std::vector<std::string>{});
    }
  }
  const Device& device() const { return *device_; }

 private:
  DeviceOptions options_;
  std::unique_ptr<Device> device_;
};

}  // namespace tetrec::test
