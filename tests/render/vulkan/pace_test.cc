// What keeps Vulkan devices busy.
#include "render/vulkan/pace.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(PaceOfDevices, IsThatOfTwoCoresInSoftware) {
  const DevicePace software = PaceOf(VK_PHYSICAL_DEVICE_TYPE_CPU), cores;
  EXPECT_EQ(software.rays_per_step, cores.rays_per_step);
  EXPECT_EQ(software.views_per_batch, cores.views_per_batch);
  EXPECT_EQ(software.speed, cores.speed);
  EXPECT_EQ(software.steps_per_motion, cores.steps_per_motion);
}

TEST(PaceOfDevices, GrowsFromSoftwareToGpusWithTheirOwnMemory) {
  const DevicePace paces[] = {PaceOf(VK_PHYSICAL_DEVICE_TYPE_CPU),
                              PaceOf(VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU),
                              PaceOf(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU)};
  for (int i = 1; i < 3; ++i) {
    EXPECT_GT(paces[i].rays_per_step, paces[i - 1].rays_per_step);
    EXPECT_GT(paces[i].views_per_batch, paces[i - 1].views_per_batch);
    EXPECT_GT(paces[i].speed, paces[i - 1].speed);
    EXPECT_GT(paces[i].steps_per_motion, paces[i - 1].steps_per_motion);
  }
}

}  // namespace
}  // namespace tetrec
