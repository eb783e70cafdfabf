// Speed of the march renderer on about 100,000 tets: rays per second of wall time and of CPU time
// for each segment integral (compare these with --benchmark_enable_random_interleaving=true), and a
// long march that counts lost rays (--lost_rays=N rays, a million by default).
#include "benchmark/stopwatch.h"
#include "core/quantile.h"
#include "core/timer.h"
#include "field/change_storage.h"
#include "march_scene.h"
#include "render/create_renderer.h"
#include "render/renderer.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace tetrec {
namespace {

// Reports the rays per second between its construction and Report.
class RayClock {
 public:
  void Report(benchmark::State& state, double rays) const {
    const double wall = wall_.seconds(), cpu = ProcessCpuSeconds() - cpu_;
    state.counters["Mrays/s_wall"] = 1e-6 * rays / wall;
    state.counters["us_cpu/ray"] = 1e6 * cpu / rays;
    state.counters["rays"] = rays;
  }

 private:
  double cpu_ = ProcessCpuSeconds();
  Timer wall_;
};

const RadianceField& BenchField() {
  static const RadianceField field = BallField(kGrid);
  return field;
}

// One renderer per integral, shared by all benchmarks, so that they do not measure how it and its
// mesh are made.
struct Stage {
  const RadianceField& field = BenchField();
  std::vector<RenderView> views = ViewsAroundCube(kViews, kPicture);
  std::unique_ptr<ProbedRenderer> renderer;

  explicit Stage(const std::string& integral) {
    RendererOptions options;
    options.integral = ParseIntegral(integral);
    renderer = Make(options);
  }

  std::unique_ptr<ProbedRenderer> Make(const RendererOptions& options,
                                       FieldStorage storage = FieldStorage::kVertex) const {
    auto made = CreateProbedRenderer(options);
    made->SetField(WithStorage(field, storage));
    const TargetImage grey{kPicture, kPicture,
                           std::vector<uint32_t>(kPicture * kPicture, 0xFF808080u)};
    made->SetTargets(views, std::vector<TargetImage>(views.size(), grey));
    return made;
  }
  static Stage& Get(const std::string& integral = "exact") {
    static std::map<std::string, Stage> stages;
    return stages.try_emplace(integral, integral).first->second;
  }
};

void Forward(benchmark::State& state, const std::string& integral) {
  Stage& stage = Stage::Get(integral);
  const std::vector<RayBlock> blocks = AllBlocks();
  size_t i = 0;
  const RayClock clock;
  for (auto _ : state) {
    benchmark::DoNotOptimize(stage.renderer->MarchBlocks(stage.views[i++ % kViews], blocks));
  }
  clock.Report(state, double(state.iterations()) * kPicture * kPicture);
}

void ForwardBackward(benchmark::State& state) {
  Stage& stage = Stage::Get();
  const std::vector<glm::vec4> gradient(kPicture * kPicture, glm::vec4(1.0f, -1.0f, 0.5f, 0.1f));
  size_t i = 0;
  const RayClock clock;
  for (auto _ : state) {
    benchmark::DoNotOptimize(stage.renderer->Backpropagate(stage.views[i++ % kViews], gradient));
  }
  clock.Report(state, double(state.iterations()) * kPicture * kPicture);
}

// Rates of zero, so that every step does the same work.
const AdamUpdate kStandingUpdate{.color_rate = 0.0, .density_rate = 0.0};
constexpr glm::vec3 kBackground(0.2f, 0.4f, 0.6f);

// Forward, loss, backward and Adam.
void RunSteps(benchmark::State& state, Stage& stage,
              const std::vector<std::vector<RayBlock>>& batches) {
  TrainingBatch step{.background_srgb = kBackground};
  size_t i = 0;
  double rays = 0;
  const RayClock clock;
  for (auto _ : state) {
    step.blocks = batches[i++ % batches.size()];
    step.seed = uint32_t(i);
    rays += double(step.blocks.size()) * kRaysPerBlock;
    benchmark::DoNotOptimize(stage.renderer->Step(step, kStandingUpdate));
  }
  benchmark::DoNotOptimize(stage.renderer->counts());  // waits for the last steps
  clock.Report(state, rays);
}

void StepOnWholePictures(benchmark::State& state, const std::string& integral) {
  std::vector<std::vector<RayBlock>> batches;
  for (uint32_t view = 0; view < kViews; ++view) batches.push_back(AllBlocks(view));
  RunSteps(state, Stage::Get(integral), batches);
}

void StepOnRandomBlocks(benchmark::State& state) {
  std::mt19937 random(2);
  std::vector<std::vector<RayBlock>> batches(64);
  for (std::vector<RayBlock>& batch : batches) {
    for (int64_t ray = 0; ray < state.range(0); ray += kRaysPerBlock) {
      batch.push_back({uint32_t(random() % kViews),
                       uint32_t(random() % (kPicture / kRayBlockWidth)) * kRayBlockWidth,
                       uint32_t(random() % (kPicture / kRayBlockHeight)) * kRayBlockHeight});
    }
  }
  RunSteps(state, Stage::Get(), batches);
}

// Number of tets that the rays of each view pass, with the early stop.
std::vector<double> StepsOfViews(const Stage& stage) {
  RendererOptions options;
  options.count_steps = true;
  const auto renderer = stage.Make(options);
  std::vector<double> steps;
  for (const RenderView& view : stage.views) {
    const uint64_t before = renderer->counts().steps;
    renderer->MarchBlocks(view, AllBlocks());
    steps.push_back(double(renderer->counts().steps - before));
  }
  return steps;
}

// The variants take turns on the same views, so that other load on the machine affects all of them
// alike. Reports medians of tet-steps per second (backward is the time that Backpropagate takes in
// addition to MarchBlocks) and of ratios.
void Compare(benchmark::State& state, int turns) {
  Stage& stage = Stage::Get();
  RendererOptions options;
  options.deterministic = true;
  const auto deterministic = stage.Make(options);
  const auto cells = stage.Make({}, FieldStorage::kCell);
  const std::vector<double> steps = StepsOfViews(stage);
  const std::vector<glm::vec4> gradient(kPicture * kPicture, glm::vec4(1.0f, -1.0f, 0.5f, 0.1f));
  std::map<std::string, std::vector<double>> values;
  for (auto _ : state) {
    for (int turn = -1; turn < turns; ++turn) {  // the first one warms up
      const uint32_t view = uint32_t(turn + 1) % kViews;
      const auto backpropagate = [&](ProbedRenderer& renderer, GradientParts parts) {
        return Measure([&] { renderer.Backpropagate(stage.views[view], gradient, parts); });
      };
      const std::vector<RayBlock> blocks = AllBlocks(view);
      const auto train = [&](ProbedRenderer& renderer) {
        const TrainingBatch step{.blocks = blocks, .background_srgb = kBackground};
        return Measure([&] {
          renderer.Step(step, kStandingUpdate);
          renderer.counts();  // waits
        });
      };
      const Seconds forward =
          Measure([&] { stage.renderer->MarchBlocks(stage.views[view], AllBlocks()); });
      const Seconds both = backpropagate(*stage.renderer, GradientParts::kColorDensity);
      const Seconds moved = backpropagate(*stage.renderer, GradientParts::kColorDensityPosition);
      const Seconds step = train(*stage.renderer), fixed = train(*deterministic),
                    of_cells = train(*cells);
      if (turn < 0) continue;
      const auto add_speed = [&](const std::string& name, double wall, double cpu) {
        values[name + "_Msteps/s_wall"].push_back(1e-6 * steps[view] / wall);
        values[name + "_Msteps/s_cpu"].push_back(1e-6 * steps[view] / cpu);
      };
      add_speed("forward", forward.wall, forward.cpu);
      add_speed("backward", both.wall - forward.wall, both.cpu - forward.cpu);
      add_speed("positions", moved.wall - forward.wall, moved.cpu - forward.cpu);
      values["deterministic_price_wall"].push_back(fixed.wall / step.wall);
      values["cells_price_cpu"].push_back(of_cells.cpu / step.cpu);
      values["deterministic_price_cpu"].push_back(fixed.cpu / step.cpu);
    }
  }
  for (const auto& [name, all] : values) state.counters[name] = Median(all);
}

// Prints the blocks of pixels that lose rays, marching each alone.
void PrintLostBlocks(ProbedRenderer& renderer, const glm::dvec3& eye, const glm::dvec3& target) {
  const RenderView view = SquareView(eye, target, kPicture);
  for (const RayBlock& block : AllBlocks()) {
    const uint64_t before = renderer.counts().lost_rays;
    renderer.MarchBlocks(view, std::vector{block});
    if (renderer.counts().lost_rays > before) {
      fmt::print("lost near pixel ({}, {}), seen from ({}, {}, {}) towards ({}, {}, {})\n", block.x,
                 block.y, eye.x, eye.y, eye.z, target.x, target.y, target.z);
    }
  }
}

// Random views from inside and outside, without the early stop: every ray must leave through the
// hull.
void LostRays(benchmark::State& state, uint64_t rays) {
  RendererOptions options;
  options.count_steps = true;
  options.stop_transmittance = 0.0f;
  const auto renderer = CreateProbedRenderer(options);
  renderer->SetField(Stage::Get().field);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> inside(0.0, 1.0), around(-2.0, 3.0);
  const std::vector<RayBlock> blocks = AllBlocks();
  uint64_t marched = 0, hit = 0, lost = 0;
  const RayClock clock;
  for (auto _ : state) {
    for (int i = 0; marched < rays; ++i) {
      auto& place = i % 2 == 0 ? inside : around;
      const glm::dvec3 eye(place(random), place(random), place(random));
      const glm::dvec3 target(inside(random), inside(random), inside(random));
      const RenderCounts before = renderer->counts();
      renderer->MarchBlocks(SquareView(eye, target, kPicture), blocks);
      const RenderCounts after = renderer->counts();
      marched += after.rays - before.rays;
      hit += after.hit_rays - before.hit_rays;
      lost += after.lost_rays - before.lost_rays;
      if (after.lost_rays > before.lost_rays) PrintLostBlocks(*renderer, eye, target);
    }
  }
  clock.Report(state, double(marched));
  state.counters["hit"] = double(hit);
  state.counters["lost"] = double(lost);
}

// Prints the size of the mesh and the steps per ray, with the early stop.
void PrintScene() {
  Stage& stage = Stage::Get();
  RendererOptions options;
  options.count_steps = true;
  const auto renderer = CreateProbedRenderer(options);
  renderer->SetField(stage.field);
  for (const RenderView& view : stage.views) renderer->MarchBlocks(view, AllBlocks());
  const RenderCounts counts = renderer->counts();
  fmt::print("device {}\n{} tets, {} vertices, {} views of {} x {} px, {:.0f} % of rays hit\n",
             renderer->DescribeDevice()["name"].get<std::string>(), stage.field.mesh.tets.size(),
             stage.field.mesh.positions.size(), kViews, kPicture, kPicture,
             100.0 * double(counts.hit_rays) / double(counts.rays));
  fmt::print("{:.1f} steps per ray, {:.1f} per ray that hits, {} lost\n",
             double(counts.steps) / double(counts.rays),
             double(counts.steps) / double(counts.hit_rays), counts.lost_rays);
}

benchmark::internal::Benchmark* InMedians(benchmark::internal::Benchmark* benchmark) {
  return benchmark->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime()
      ->UseRealTime()
      ->ReportAggregatesOnly();
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  using namespace tetrec;
  const std::string rays_flag = "--lost_rays=", turns_flag = "--turns=";
  uint64_t lost_rays = 1'000'000;
  int turns = 33;
  // Options of the command line come later, so they take precedence.
  std::string min_time = "--benchmark_min_time=0.3", repetitions = "--benchmark_repetitions=5";
  std::vector<char*> rest{argv[0], min_time.data(), repetitions.data()};
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with(rays_flag)) {
      lost_rays = std::stoull(argument.substr(rays_flag.size()));
    } else if (argument.starts_with(turns_flag)) {
      turns = std::stoi(argument.substr(turns_flag.size()));
    } else {
      rest.push_back(argv[i]);
    }
  }
  int count = int(rest.size());
  benchmark::Initialize(&count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(count, rest.data())) return 2;
  PrintScene();
  for (const std::string integral : {"mean", "split:1", "split:4", "split:16", "exact"}) {
    InMedians(benchmark::RegisterBenchmark(("Forward/" + integral).c_str(), Forward, integral));
    InMedians(benchmark::RegisterBenchmark(("StepOnWholePictures/" + integral).c_str(),
                                           StepOnWholePictures, integral));
  }
  InMedians(benchmark::RegisterBenchmark("ForwardBackward", ForwardBackward));
  InMedians(benchmark::RegisterBenchmark("StepOnRandomBlocks", StepOnRandomBlocks)
                ->Arg(1024)
                ->Arg(4096)
                ->Arg(16384));
  benchmark::RegisterBenchmark("Compare", Compare, turns)
      ->Unit(benchmark::kSecond)
      ->Iterations(1)
      ->Repetitions(1);
  benchmark::RegisterBenchmark("LostRays", LostRays, lost_rays)
      ->Unit(benchmark::kSecond)
      ->Iterations(1)
      ->Repetitions(1);
  benchmark::RunSpecifiedBenchmarks();
}
