// Compares the Vulkan march with one written by hand for AVX2, in turns on the same mesh and views.
#include "benchmark/stopwatch.h"
#include "core/quantile.h"
#include "hand_march.h"
#include "march_scene.h"
#include "render/create_renderer.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr float kStop = 1e-3f;

// Largest difference of colour and transmittance over all views, and the number of rays that differ
// by more than rounding can explain. The early stop may come one tet later, which changes the
// colour by at most the transmittance there.
struct Differences {
  double largest = 0;
  uint64_t above_rounding = 0, rays = 0;
};

Differences Compare(ProbedRenderer& vulkan, const HandMarch& hand,
                    const std::vector<RenderView>& views, const std::vector<RayBlock>& blocks) {
  Differences result;
  for (const RenderView& view : views) {
    const auto a = vulkan.MarchBlocks(view, blocks);
    const auto b = hand.MarchBlocks(view, blocks, kStop);
    for (size_t i = 0; i < a.size(); ++i) {
      double difference = std::abs(std::exp(-a[i].a) - std::exp(-b[i].a));
      for (int c = 0; c < 3; ++c) {
        difference = std::max(difference, std::abs(double(a[i][c]) - b[i][c]));
      }
      result.largest = std::max(result.largest, difference);
      result.above_rounding += difference > 1e-4;
      ++result.rays;
    }
  }
  return result;
}

void VulkanAgainstHand(benchmark::State& state) {
  constexpr int kTurns = 65;
  const RadianceField field = BallField(kGrid);
  const std::vector<RenderView> views = ViewsAroundCube(kViews, kPicture);
  const std::vector<RayBlock> blocks = AllBlocks();
  const auto vulkan = CreateProbedRenderer({.stop_transmittance = kStop});
  vulkan->SetField(field);
  const HandMarch hand(field);
  const Differences differences = Compare(*vulkan, hand, views, blocks);
  fmt::print("{} tets; {} rays, of which {} differ by more than 1e-4, at most by {:.1e}\n",
             field.mesh.tets.size(), differences.rays, differences.above_rounding,
             differences.largest);
  if (differences.largest > 2 * kStop || differences.above_rounding > differences.rays / 1000) {
    state.SkipWithError("the images differ");
    return;
  }
  std::vector<double> vulkan_wall, vulkan_cpu, hand_wall, hand_cpu, wall_ratio, cpu_ratio;
  for (auto _ : state) {
    for (int turn = -1; turn < kTurns; ++turn) {  // the first one warms up
      const RenderView& view = views[size_t(turn + 1) % kViews];
      const Seconds a = Measure([&] { vulkan->MarchBlocks(view, blocks); });
      const Seconds b = Measure([&] { hand.MarchBlocks(view, blocks, kStop); });
      if (turn < 0) continue;
      const double rays = double(blocks.size()) * kRaysPerBlock;
      vulkan_wall.push_back(1e-6 * rays / a.wall), hand_wall.push_back(1e-6 * rays / b.wall);
      vulkan_cpu.push_back(1e6 * a.cpu / rays), hand_cpu.push_back(1e6 * b.cpu / rays);
      wall_ratio.push_back(b.wall / a.wall), cpu_ratio.push_back(b.cpu / a.cpu);
    }
  }
  state.counters["vulkan_Mrays/s"] = Median(vulkan_wall);
  state.counters["hand_Mrays/s"] = Median(hand_wall);
  state.counters["vulkan_us_cpu/ray"] = Median(vulkan_cpu);
  state.counters["hand_us_cpu/ray"] = Median(hand_cpu);
  state.counters["vulkan/hand_speed_wall"] = Median(wall_ratio);
  state.counters["vulkan/hand_speed_cpu"] = Median(cpu_ratio);
  fmt::print(
      "the Vulkan march reaches {:.0f} % of the speed of the hand-written one by wall time, "
      "{:.0f} % by CPU time\n",
      100 * Median(wall_ratio), 100 * Median(cpu_ratio));
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  using namespace tetrec;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  if (!HandMarch::CanRun()) {
    fmt::print("this CPU lacks AVX2 or FMA, which the hand-written march requires\n");
    return 0;
  }
  benchmark::RegisterBenchmark("VulkanAgainstHand", VulkanAgainstHand)
      ->Unit(benchmark::kSecond)
      ->Iterations(1);
  benchmark::RunSpecifiedBenchmarks();
}
