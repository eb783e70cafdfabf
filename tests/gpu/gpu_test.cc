// Devices, buffers, and the barriers that the command recorder derives.
#include "embedded_shaders.h"
#include "expect_error.h"
#include "gpu/buffer.h"
#include "gpu/commands.h"
#include "gpu/program.h"
#include "gpu/raster_program.h"
#include "shared/gpu_types.glsl.h"
#include "test_shaders.h"
#include "vulkan_test.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace tetrec::test {
namespace {

using ::testing::HasSubstr;

struct AffinePush {
  uint32_t count, factor;
};

Program MakeAffine(const Device& device) { return Program(device, "affine", kAffine); }

std::vector<uint32_t> Counted(uint32_t count) {
  std::vector<uint32_t> values(count);
  std::iota(values.begin(), values.end(), 0u);
  return values;
}

TEST_F(VulkanTest, BufferGivesBackWhatWasPutIn) {
  const std::vector<uint32_t> values = Counted(1000);
  Buffer buffer = MakeBuffer(device(), "values", values);
  EXPECT_EQ(buffer.DownloadAs<uint32_t>(1000), values);
  const uint32_t seven = 7;
  buffer.Upload(&seven, 4, 40);
  EXPECT_EQ(buffer.DownloadAs<uint32_t>(12)[10], 7u);
  buffer.FillZero();
  EXPECT_EQ(buffer.DownloadAs<uint32_t>(1000), std::vector<uint32_t>(1000, 0u));
}

TEST_F(VulkanTest, BufferRefusesToBeOverrun) {
  Buffer buffer(device(), "small", 64);
  std::vector<uint32_t> values(17);
  EXPECT_THROW(buffer.Upload(values), BugError);
  EXPECT_THROW(buffer.Download(values.data(), 4, 64), BugError);
}

TEST_F(VulkanTest, BufferBeyondTheDevicesLimitIsAnEnvironmentError) {
  const uint64_t limit = device().properties.limits.maxStorageBufferRange;
  EXPECT_THROW(Buffer(device(), "huge", limit + 4), EnvironmentError);
}

TEST_F(VulkanTest, DispatchReadsWhatTheOneBeforeWrote) {
  const Program affine = MakeAffine(device());
  const uint32_t count = 100'000;
  Buffer a = MakeBuffer(device(), "a", Counted(count)), b(device(), "b", 4 * count);
  CommandRecorder recorder(device());
  recorder.Begin();
  const BoundBuffers a_to_b = {{0, a}, {1, b}};
  const BoundBuffers b_to_a = {{0, b}, {1, a}};
  recorder.Dispatch(affine, a_to_b, AffinePush{count, 3}, count);
  EXPECT_EQ(recorder.barriers(), 0u);
  recorder.Dispatch(affine, b_to_a, AffinePush{count, 5}, count);
  EXPECT_EQ(recorder.barriers(), 1u);
  recorder.Dispatch(affine, a_to_b, AffinePush{count, 2}, count);
  EXPECT_EQ(recorder.barriers(), 2u);
  recorder.EndAndSubmit();
  recorder.Wait();
  const auto result = b.DownloadAs<uint32_t>(count);
  for (uint32_t i = 0; i < count; ++i) {
    ASSERT_EQ(result[i], 2 * (5 * (3 * i + 1) + 1) + 1) << "i = " << i;
  }
}

TEST_F(VulkanTest, DispatchOfMoreWorkgroupsThanARowHoldsReachesEveryThreadOnce) {
  const uint64_t row = uint64_t(device().properties.limits.maxComputeWorkGroupCount[0]) * 64;
  const uint64_t count = row + 1000;
  if (4 * count > device().properties.limits.maxStorageBufferRange) {
    GTEST_SKIP() << "a row of workgroups has more threads than a buffer has words";
  }
  const Program affine = MakeAffine(device());
  const Buffer a = MakeBuffer(device(), "a", Counted(uint32_t(count)));
  const Buffer b(device(), "b", 4 * count);
  CommandRecorder recorder(device());
  recorder.Begin();
  const BoundBuffers a_to_b = {{0, a}, {1, b}};
  EXPECT_THROW(recorder.Dispatch(affine, a_to_b, AffinePush{uint32_t(count), 3}, count), BugError);
  recorder.DispatchMany(affine, a_to_b, AffinePush{uint32_t(count), 3}, count);
  recorder.EndAndSubmit();
  recorder.Wait();
  const auto result = b.DownloadAs<uint32_t>(count);
  for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(result[i], 3 * i + 1) << "i = " << i;
}

// The first dispatch writes how many workgroups the second one has: 1, 2, 1.
TEST_F(VulkanTest, DispatchOfCountedWorkgroupsReadsWhatTheOneBeforeWrote) {
  const Program affine = MakeAffine(device());
  const Buffer source = MakeBuffer(device(), "source", std::vector<uint32_t>{0, 1, 0});
  const Buffer groups = MakeBuffer(device(), "groups", std::vector<uint32_t>{9, 9, 9});
  const Buffer a = MakeBuffer(device(), "a", Counted(1000)), b(device(), "b", 4000);
  CommandRecorder recorder(device());
  recorder.Begin();
  recorder.FillZero(b);
  recorder.Dispatch(affine, {{0, source}, {1, groups}}, AffinePush{3, 1}, 3);
  recorder.DispatchCounted(affine, {{0, a}, {1, b}}, AffinePush{1000, 3}, groups);
  EXPECT_EQ(recorder.barriers(), 1u);
  recorder.EndAndSubmit();
  recorder.Wait();
  const auto result = b.DownloadAs<uint32_t>(1000);
  for (uint32_t i = 0; i < 1000; ++i) {
    ASSERT_EQ(result[i], i < 128 ? 3 * i + 1 : 0) << "i = " << i;
  }
}

TEST_F(VulkanTest, TwoDispatchesThatWriteOneBufferAreKeptApart) {
  const Program affine = MakeAffine(device());
  Buffer a = MakeBuffer(device(), "a", Counted(64)), b = MakeBuffer(device(), "b", Counted(64));
  Buffer out(device(), "out", 4 * 64);
  CommandRecorder recorder(device());
  recorder.Begin();
  const BoundBuffers from_a = {{0, a}, {1, out}};
  const BoundBuffers from_b = {{0, b}, {1, out}};
  recorder.Dispatch(affine, from_a, AffinePush{64, 1}, 64);
  recorder.Dispatch(affine, from_b, AffinePush{64, 10}, 64);
  EXPECT_EQ(recorder.barriers(), 1u);
  recorder.EndAndSubmit();
  recorder.Wait();
  EXPECT_EQ(out.DownloadAs<uint32_t>(64)[63], 631u);
}

TEST_F(VulkanTest, DispatchesThatShareOnlyWhatTheyReadNeedNoBarrier) {
  const Program affine = MakeAffine(device());
  Buffer in = MakeBuffer(device(), "in", Counted(64));
  Buffer a(device(), "a", 4 * 64), b(device(), "b", 4 * 64);
  CommandRecorder recorder(device());
  recorder.Begin();
  const BoundBuffers to_a = {{0, in}, {1, a}};
  const BoundBuffers to_b = {{0, in}, {1, b}};
  recorder.Dispatch(affine, to_a, AffinePush{64, 1}, 64);
  recorder.Dispatch(affine, to_b, AffinePush{64, 2}, 64);
  EXPECT_EQ(recorder.barriers(), 0u);
  recorder.EndAndSubmit();
  recorder.Wait();
  EXPECT_EQ(b.DownloadAs<uint32_t>(64)[5], 11u);
}

// The message names the kernel and the binding.
TEST_F(VulkanTest, DispatchWithBuffersThatAreNotTheKernelsIsABug) {
  const Program affine = MakeAffine(device());
  const Buffer a(device(), "a", 64), b(device(), "b", 64), none;
  CommandRecorder recorder(device());
  recorder.Begin();
  const auto expect_bug = [&](const BoundBuffers& buffers, const char* words) {
    try {
      recorder.Dispatch(affine, buffers, AffinePush{1, 1}, 1);
      FAIL() << words;
    } catch (const BugError& error) {
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
  };
  expect_bug({{0, a}}, "kernel affine: no buffer for binding 1 (Out)");
  expect_bug({{0, a}, {1, b}, {2, b}}, "kernel affine has no binding 2 for buffer 'b'");
  expect_bug({{0, a}, {1, b}, {1, a}}, "kernel affine: the buffer 'a' for binding 1 (Out)");
  expect_bug({{0, none}, {1, b}}, "kernel affine: the buffer '' for binding 0 (In)");
  EXPECT_THROW(recorder.Dispatch(affine, {{0, a}, {1, b}}, uint32_t(1), 1), BugError);
  recorder.EndAndSubmit();
  recorder.Wait();
}

TEST_F(VulkanTest, BuffersMayComeInAnyOrder) {
  const Program affine = MakeAffine(device());
  const Buffer a = MakeBuffer(device(), "a", Counted(64)), b(device(), "b", 4 * 64);
  CommandRecorder recorder(device());
  recorder.Begin();
  recorder.Dispatch(affine, {{1, b}, {0, a}}, AffinePush{64, 2}, 64);
  recorder.EndAndSubmit();
  recorder.Wait();
  EXPECT_EQ(b.DownloadAs<uint32_t>(64)[5], 11u);
}

TEST_F(VulkanTest, TexelBufferWithoutAFormatIsABug) {
  const Program keys(device(), "keys", kProjectionKeysPower);
  const Buffer words(device(), "words", 64);
  CommandRecorder recorder(device());
  recorder.Begin();
  try {
    recorder.Dispatch(
        keys,
        {{kBindItems, words}, {kBindKeys, words}, {kBindSpheres, words}, {kBindHighKeys, words}},
        gpu_types::ProjectionPush{}, 1);
    ADD_FAILURE();
  } catch (const BugError& error) {
    EXPECT_THAT(error.what(), HasSubstr("kernel keys: binding 25 (spheres) needs a texel buffer"));
  }
  recorder.EndAndSubmit();
  recorder.Wait();
}

TEST_F(VulkanTest, ConstantThatTheKernelLacksIsABug) {
  const SpecializationConstant constants[] = {{7, 1}};
  EXPECT_THROW(Program(device(), "affine", kAffine, constants), BugError);
}

// A dispatch writes what a draw reads, a draw writes what a dispatch reads, and only the area gets
// fragments.
TEST_F(VulkanTest, DrawsAndDispatchesAreKeptApartAndDrawsKeepToTheirArea) {
  if (!device().has_raster) GTEST_SKIP() << "the device does not rasterise";
  struct StairsPush {
    uint32_t width, step;
  };
  constexpr uint32_t kWidth = 16, kHeight = 8;
  const Program stairs = MakeRasterProgram(device(), "stairs", kStairsvert, kStairsfrag);
  const Program affine = MakeAffine(device());
  Buffer ones = MakeBuffer(device(), "ones", std::vector<uint32_t>{1});
  Buffer steps(device(), "steps", 4), counts(device(), "counts", 4 * kWidth * kHeight);
  Buffer result(device(), "result", 4 * kWidth * kHeight);
  CommandRecorder recorder(device());
  recorder.Begin();
  const BoundBuffers ones_to_steps = {{0, ones}, {1, steps}};
  const BoundBuffers steps_to_counts = {{0, steps}, {1, counts}};
  const BoundBuffers counts_to_result = {{0, counts}, {1, result}};
  recorder.FillZero(counts);
  recorder.Dispatch(affine, ones_to_steps, AffinePush{1, 2}, 1);  // 1 * 2 + 1
  recorder.Draw(stairs, steps_to_counts, StairsPush{kWidth, 1}, 3 * 4, {0, 0, kWidth, kHeight},
                {2, 1, kWidth - 2, kHeight - 3});
  EXPECT_EQ(recorder.barriers(), 1u);
  recorder.Draw(stairs, steps_to_counts, StairsPush{kWidth, 10}, 3, {0, 0, kWidth, kHeight},
                {0, 0, 1, 1});
  EXPECT_EQ(recorder.barriers(), 2u);
  recorder.Dispatch(affine, counts_to_result, AffinePush{kWidth * kHeight, 1}, kWidth * kHeight);
  EXPECT_EQ(recorder.barriers(), 3u);
  recorder.EndAndSubmit();
  recorder.Wait();
  const auto values = result.DownloadAs<uint32_t>(kWidth * kHeight);
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      const bool in_area = x >= 2 && y >= 1 && y < kHeight - 2;
      const uint32_t expected = (in_area ? 3 * std::min(x + 1, 4u) : 0) + (x + y == 0 ? 30 : 0);
      ASSERT_EQ(values[y * kWidth + x], expected + 1) << x << ", " << y;
    }
  }
}

TEST_F(VulkanTest, DeviceThatIsNotThereIsAnEnvironmentError) {
  const std::string name = CreateDevice({.device = "0"})->properties.deviceName;
  ExpectError<EnvironmentError>([] { CreateDevice({.device = "999"}); },
                                {"no Vulkan device 999", fmt::format("0 ({})", name)});
  EXPECT_THROW(CreateDevice({.device = "99999999999999999999"}), EnvironmentError);
}

TEST_F(VulkanTest, DeviceWithoutMeaningIsAUsageError) {
  EXPECT_THROW(CreateDevice({.device = "toaster"}), UsageError);
  EXPECT_THROW(CreateDevice({.device = ""}), UsageError);
}

TEST_F(VulkanTest, DevicesCanBeChosenByNumberAndByKind) {
  EXPECT_NE(CreateDevice({.device = "0"}), nullptr);
  try {
    EXPECT_EQ(DescribeDevice(*CreateDevice({.device = "cpu"}))["type"], "software");
  } catch (const EnvironmentError& error) {
    GTEST_SKIP() << error.what();
  }
}

TEST_F(VulkanTest, FloatAtomicsCanBeTurnedOff) {
  EXPECT_FALSE(CreateDevice({.float_atomics = false})->has_float_atomics);
}

TEST_F(VulkanTest, MemoryUseFollowsTheBuffers) {
  const MemoryUse& use = *device().memory_use;
  const uint64_t before = use.bytes;
  {
    const Buffer one(device(), "one", 1000);
    Buffer two(device(), "two", 500);
    EXPECT_EQ(use.bytes, before + 1500);
    const Buffer three = std::move(two);
    EXPECT_EQ(use.bytes, before + 1500);
  }
  EXPECT_EQ(use.bytes, before);
  EXPECT_EQ(use.most_bytes, before + 1500);
}

}  // namespace
}  // namespace tetrec::test
