// Device time by kernel, from timestamps.
#include "render/kernel_table.h"
#include "render/scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>

namespace tetrec::test {
namespace {

std::map<std::string, KernelTime> ByName(const KernelReport& report) {
  std::map<std::string, KernelTime> kernels;
  for (const KernelTime& kernel : report.kernels) kernels[kernel.name] = kernel;
  return kernels;
}

RendererOptions Timed(RendererKind kind) {
  RendererOptions options{.kind = kind};
  options.device.time_kernels = true;
  return options;
}

void TakeSteps(ProbedRenderer& renderer, int count) {
  const RenderView view = LookAt({1.7, -1.1, -1.0}, {0.0, 0.3, 0.6}, 64, 48);
  const TargetImage grey{64, 48, std::vector<uint32_t>(64 * 48, 0xFF808080u)};
  renderer.SetField(RandomField(500, 61, 5.0f));
  renderer.SetTargets(std::vector{view}, std::vector{grey});
  const auto blocks = AllBlocks(view.camera);
  for (int i = 1; i <= count; ++i) {
    renderer.Step({.blocks = blocks, .seed = uint32_t(i)}, {.step = uint32_t(i)});
  }
}

TEST_F(RendererTest, TimestampsCountEveryKernelOfStepsInFlight) {
  for (RendererKind kind : {RendererKind::kMarch, RendererKind::kPpll, RendererKind::kProjection}) {
    ProbedRenderer& renderer = MakeRenderer(Timed(kind));
    const auto start = std::chrono::steady_clock::now();
    TakeSteps(renderer, 5);
    const KernelReport report = renderer.KernelTimes();
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!report.has_timestamps) GTEST_SKIP() << "the device has no timestamps";
    const auto kernels = ByName(report);
    for (const char* name : {"loss", "adam"}) {
      ASSERT_TRUE(kernels.contains(name)) << name;
      EXPECT_EQ(kernels.at(name).calls, 5u) << name;
    }
    double total = 0;
    for (const auto& [name, kernel] : kernels) {
      EXPECT_GE(kernel.seconds, 0.0) << name;
      total += kernel.seconds;
    }
    // There is one queue: times do not overlap, and together they are no longer than the run.
    EXPECT_GT(total, 0.0);
    EXPECT_LE(total, wall);
    if (kind == RendererKind::kMarch) {
      EXPECT_EQ(kernels.at("march_forward").calls, 5u);
      EXPECT_EQ(report.untimed_calls, 0u);
    }
  }
}

TEST_F(RendererTest, NothingIsTimedUnlessAskedFor) {
  ProbedRenderer& renderer = MakeRenderer();
  TakeSteps(renderer, 2);
  EXPECT_FALSE(renderer.KernelTimes().has_timestamps);
  EXPECT_TRUE(renderer.KernelTimes().kernels.empty());
}

TEST(KernelTable, NamesTheLongestFirstWithItsShare) {
  const KernelReport report{true, {{"short", 1000, 0.25}, {"a longer one", 2, 0.75}}};
  const std::vector<std::string> lines = KernelTable(report);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[1],
              ::testing::AllOf(::testing::StartsWith("a longer one "),
                               ::testing::HasSubstr(" 750.0 "), ::testing::EndsWith("75.0 %")));
  EXPECT_THAT(lines[2], ::testing::HasSubstr(" 1,000 "));
}

}  // namespace
}  // namespace tetrec::test
