// What keeps Vulkan devices busy.
#include "render/vulkan/pace.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(PaceOfDevices, IsThatOfTwoCoresInSoftware) {
  EXPECT_EQ(PaceOf(VK_PHYSICAL_DEVICE_TYPE_CPU), DevicePace());
  EXPECT_EQ(PaceOf(VK_PHYSICAL_DEVICE_TYPE_OTHER), DevicePace());
}

TEST(PaceOfDevices, GrowsFromSoftwareToGpusWithTheirOwnMemory) {
  const DevicePace paces[] = {PaceOf(VK_PHYSICAL_DEVICE_TYPE_CPU),
                              PaceOf(VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU),
                              PaceOf(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU)};
  EXPECT_EQ(paces[1], PaceOf(VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU));
  for (int i = 1; i < 3; ++i) {
    EXPECT_GT(paces[i].rays_per_step, paces[i - 1].rays_per_step);
    EXPECT_GT(paces[i].views_per_batch, paces[i - 1].views_per_batch);
    EXPECT_GT(paces[i].speed, paces[i - 1].speed);
    EXPECT_GT(paces[i].steps_per_motion, paces[i - 1].steps_per_motion);
  }
}

}  // namespace
}  // namespace tetrec
