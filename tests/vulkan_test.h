// A Vulkan device with validation for tests; a message of the layer fails the test that caused it.
#pragma once

#include "core/error.h"
#include "gpu/device.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace tetrec::test {

class VulkanTest : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      device_ = CreateDevice({.validation = true});
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
  std::unique_ptr<Device> device_;
};

}  // namespace tetrec::test
