// Buffers in memory that the host cannot reach.
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/program.h"
#include "test_shaders.h"
#include "vulkan_test.h"

#include <gtest/gtest.h>

#include <numeric>

namespace tetrec::test {
namespace {

class StagingTest : public VulkanTest {
 protected:
  StagingTest() : VulkanTest({.maps_buffers = false}) {}
};

std::vector<uint32_t> CountedFromOne(size_t count) {
  std::vector<uint32_t> values(count);
  std::iota(values.begin(), values.end(), 1u);
  return values;
}

// 40 MB: three parts of the staging area, the last one smaller.
TEST_F(StagingTest, CopiesMoreThanTheStagingAreaHolds) {
  const std::vector<uint32_t> values = CountedFromOne(10'000'019);
  Buffer buffer = MakeBuffer(device(), "values", values);
  EXPECT_EQ(buffer.DownloadAs<uint32_t>(values.size()), values);
}

TEST_F(StagingTest, CopiesPartsOfABuffer) {
  Buffer buffer = MakeBuffer(device(), "values", CountedFromOne(1000));
  const std::vector<uint32_t> part = {70, 80};
  buffer.Upload(part.data(), 8, 40);
  std::vector<uint32_t> back(4);
  buffer.Download(back.data(), 16, 36);
  EXPECT_EQ(back, (std::vector<uint32_t>{10, 70, 80, 13}));
  buffer.FillZero();
  EXPECT_EQ(buffer.DownloadAs<uint32_t>(1000), std::vector<uint32_t>(1000, 0u));
}

TEST_F(StagingTest, KernelsReadWhatTheHostWritesAndWriteWhatItReads) {
  struct Push {
    uint32_t count, factor;
  };
  constexpr uint32_t kCount = 1000;
  const Program affine(device(), "affine", kAffine);
  Buffer in(device(), "in", 4 * kCount, VK_FORMAT_UNDEFINED, BufferHome::kHostWrites);
  const Buffer between(device(), "between", 4 * kCount);
  const Buffer out(device(), "out", 4 * kCount, VK_FORMAT_UNDEFINED, BufferHome::kHostReads);
  CommandRecorder recorder(device());
  for (const uint32_t factor : {3u, 4u}) {
    in.Upload(CountedFromOne(kCount));
    recorder.Begin();
    recorder.Dispatch(affine, {{0, in}, {1, between}}, Push{kCount, factor}, kCount);
    recorder.Dispatch(affine, {{0, between}, {1, out}}, Push{kCount, 5}, kCount);
    recorder.EndAndSubmit();
    recorder.Wait();
    const auto result = out.DownloadAs<uint32_t>(kCount);
    for (uint32_t i = 0; i < kCount; ++i) {
      ASSERT_EQ(result[i], 5 * (factor * (i + 1) + 1) + 1) << "i = " << i;
    }
  }
}

}  // namespace
}  // namespace tetrec::test
