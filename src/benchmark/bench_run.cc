// Measures renderers, orders and integrals on the same meshes and views.
#include "benchmark/bench_run.h"

#include "benchmark/stopwatch.h"
#include "core/error.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "core/spread_choice.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "field/change_storage.h"
#include "render/create_renderer.h"
#include "render/ray_blocks.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <random>

namespace tetrec {
namespace {

constexpr int kViews = 4, kErrorViews = 2;

using RendererPointer = std::unique_ptr<ProbedRenderer>;

std::vector<glm::vec4> RandomGradient(const RenderView& view, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  std::vector<glm::vec4> gradient(size_t(view.camera.width) * size_t(view.camera.height));
  for (glm::vec4& g : gradient) {
    for (int i = 0; i < 4; ++i) g[i] = normal(random);
  }
  return gradient;
}

// Sums of squares of differences and of the true values.
struct Squares {
  double difference = 0, truth = 0;

  void Add(double value, double true_value) {
    difference += (value - true_value) * (value - true_value);
    truth += true_value * true_value;
  }
  double Relative() const { return truth > 0 ? std::sqrt(difference / truth) : 0.0; }
};

constexpr GradientParts kAllParts = GradientParts::kColorDensityPosition;

// Images and gradients of a mesh.
struct Shown {
  std::vector<RenderedImage> images;
  std::vector<FieldGradient> gradients;
};

Shown Show(ProbedRenderer& renderer, const std::vector<RenderView>& views, GradientParts parts,
           uint64_t seed) {
  Shown shown;
  for (const RenderView& view : views) {
    shown.images.push_back(renderer.Render(view, 1));
    shown.gradients.push_back(renderer.Backpropagate(view, RandomGradient(view, seed), parts));
  }
  return shown;
}

BenchErrors ErrorsOf(const Shown& shown, const Shown& truth) {
  BenchErrors errors;
  double squares = 0, count = 0;
  Squares color, density, position;
  for (size_t i = 0; i < truth.images.size(); ++i) {
    const RenderedImage &a = shown.images[i], &b = truth.images[i];
    for (size_t p = 0; p < b.color_srgb.size(); ++p) {
      for (int c = 0; c < 3; ++c) {
        const double over_black = double(a.color_srgb[p][c]) - b.color_srgb[p][c];
        const double over_white = over_black + double(a.transmittance[p]) - b.transmittance[p];
        errors.largest = std::max({errors.largest, std::abs(over_black), std::abs(over_white)});
        squares += over_black * over_black + over_white * over_white;
        count += 2;
      }
    }
    const FieldGradient &g = shown.gradients[i], &h = truth.gradients[i];
    for (size_t row = 0; row < h.density.size(); ++row) {
      density.Add(g.density[row], h.density[row]);
      for (int c = 0; c < 3; ++c) color.Add(g.color_srgb[row][c], h.color_srgb[row][c]);
    }
    // One per vertex, whatever the rows of attributes belong to.
    for (size_t v = 0; v < g.position.size(); ++v) {
      for (int c = 0; c < 3; ++c) position.Add(g.position[v][c], h.position[v][c]);
    }
  }
  errors.rms = std::sqrt(squares / count);
  errors.color = color.Relative();
  errors.density = density.Relative();
  errors.position = position.Relative();
  return errors;
}

RendererPointer MakeWith(const RadianceField& field, RendererOptions options) {
  RendererPointer renderer = CreateProbedRenderer(options);
  renderer->SetField(field);
  return renderer;
}

// Errors are measured without early stop on either side: otherwise rounding would decide which tet
// is the last of a ray, which matters by a thousandth.
RendererPointer MakeForErrors(const RadianceField& field, RendererOptions options) {
  options.stop_transmittance = 0.0f;
  return MakeWith(field, options);
}

// Number of tets that the rays of each view pass.
std::vector<double> StepsOf(const RadianceField& field, const std::vector<RenderView>& views,
                            RendererKind counter, RendererOptions options) {
  options.kind = counter;
  options.count_steps = true;
  const RendererPointer renderer = MakeWith(field, options);
  std::vector<double> steps;
  uint64_t before = 0;
  for (const RenderView& view : views) {
    renderer->MarchBlocks(view, CoveringBlocks(view.camera.width, view.camera.height));
    steps.push_back(double(renderer->counts().steps - before));
    before = renderer->counts().steps;
  }
  return steps;
}

void Add(BenchTime& time, const Seconds& seconds) {
  time.wall.push_back(1e3 * seconds.wall);
  time.cpu.push_back(1e3 * seconds.cpu);
}

// One variant on one mesh and image size.
struct Case {
  BenchRow row;
  double seconds = 0;  // of all its turns
  double last_turn = 0;
  bool warm = false;

  bool WantsTurn(const BenchOptions& options) const {
    if (row.skipped_seconds) return false;
    const int turns = int(row.forward.wall.size());
    if (turns == 0) return true;
    return turns < options.repeat && seconds + last_turn <= options.case_seconds;
  }

  // The first turn warms up: buffers grow, and caches fill with the mesh. It counts only if there
  // is no time for another.
  void TakeTurn(ProbedRenderer& renderer, const RenderView& view,
                std::span<const glm::vec4> gradient, const BenchOptions& options) {
    const auto blocks = CoveringBlocks(view.camera.width, view.camera.height);
    BenchRow turn;
    const Seconds all = Measure([&] {
      Add(turn.forward, Measure([&] { renderer.MarchBlocks(view, blocks); }));
      Add(turn.backward, Measure([&] { renderer.Backpropagate(view, gradient); }));
      Add(turn.positions,
          Measure([&] { renderer.Backpropagate(view, gradient, GradientParts::kMotion); }));
    });
    seconds += all.wall;
    last_turn = all.wall;
    if (!std::exchange(warm, true) && 2 * all.wall <= options.case_seconds) return;
    const auto append = [](BenchTime& to, const BenchTime& from) {
      to.wall.insert(to.wall.end(), from.wall.begin(), from.wall.end());
      to.cpu.insert(to.cpu.end(), from.cpu.begin(), from.cpu.end());
    };
    append(row.forward, turn.forward);
    append(row.backward, turn.backward);
    append(row.positions, turn.positions);
  }
};

// Upper bound for one turn: the time of a smaller image scaled by the number of pixels, or of a
// smaller mesh scaled by the number of tets.
double MostSeconds(const std::vector<Case>& done, const BenchRow& row) {
  double most = 0;
  for (const Case& other : done) {
    const BenchVariant &a = other.row.variant, &b = row.variant;
    const bool same = a.renderer == b.renderer && a.order == b.order && a.integral == b.integral;
    const bool smaller = other.row.tets <= row.tets && other.row.size <= row.size;
    if (!same || !smaller) continue;
    const double by_last = other.row.skipped_seconds.value_or(other.last_turn);
    const double bound = by_last * (row.rays / other.row.rays) *
                         std::max(1.0, double(row.tets) / double(other.row.tets));
    most = most == 0 ? bound : std::min(most, bound);
  }
  return most;
}

class Bench {
 public:
  Bench(const BenchOptions& options, std::function<std::vector<RenderView>(int size)> views)
      : options_(options), variants_(VariantsOf(options)), views_(std::move(views)) {}

  void RunOn(const RadianceField& field) {
    LogInfo("{} tets, {} vertices", WithThousands(field.mesh.tets.size()),
            WithThousands(field.mesh.positions.size()));
    const std::vector<BenchErrors> errors = MeasureErrors(field);
    std::vector<RendererPointer> renderers;
    for (const BenchVariant& variant : variants_) {
      renderers.push_back(MakeWith(field, variant.options));
    }
    if (device_.empty()) device_ = renderers[0]->DescribeDevice()["name"].get<std::string>();
    for (int size : options_.sizes) RunOn(field, size, errors, renderers);
  }

  std::vector<BenchRow> Rows() const {
    std::vector<BenchRow> rows;
    for (const Case& one : done_) rows.push_back(one.row);
    return rows;
  }
  const std::string& device() const { return device_; }

 private:
  std::vector<BenchErrors> MeasureErrors(const RadianceField& field) const {
    std::vector<RenderView> views = views_(options_.error_size);
    views.resize(std::min<size_t>(views.size(), kErrorViews));
    RendererOptions exact = options_.renderer;
    exact.kind = RendererKind::kReference;
    const Timer timer;
    const Shown truth = Show(*MakeForErrors(field, exact), views, kAllParts, options_.seed);
    std::vector<BenchErrors> errors;
    for (const BenchVariant& variant : variants_) {
      ThrowIfStopRequested("nothing was measured");
      const RendererPointer renderer = MakeForErrors(field, variant.options);
      errors.push_back(ErrorsOf(Show(*renderer, views, kAllParts, options_.seed), truth));
    }
    LogInfo("errors measured in {:.1f} s", timer.seconds());
    return errors;
  }

  void RunOn(const RadianceField& field, int size, const std::vector<BenchErrors>& errors,
             const std::vector<RendererPointer>& renderers) {
    const Timer timer;
    const std::vector<RenderView> views = views_(size);
    const std::vector<glm::vec4> gradient = RandomGradient(views[0], options_.seed);
    std::vector<Case> cases(variants_.size());
    for (size_t i = 0; i < cases.size(); ++i) {
      BenchRow& row = cases[i].row;
      row.variant = variants_[i];
      row.tets = field.mesh.tets.size();
      row.vertices = field.mesh.positions.size();
      row.storage = field.storage;
      row.size = size;
      row.rays = double(size) * size;
      row.errors = errors[i];
      const double most = MostSeconds(done_, row);
      if (most > options_.longest_turn) row.skipped_seconds = most;
    }
    ThrowIfStopRequested("nothing was measured");
    CountSteps(field, views, cases);
    bool again = true;
    for (size_t turn = 0; again; ++turn) {
      again = false;
      for (size_t i = 0; i < cases.size(); ++i) {
        if (!cases[i].WantsTurn(options_)) continue;
        ThrowIfStopRequested("nothing was measured");
        cases[i].TakeTurn(*renderers[i], views[turn % views.size()], gradient, options_);
        again = true;
      }
    }
    for (size_t i = 0; i < cases.size(); ++i) {
      cases[i].row.device_bytes = renderers[i]->counts().device_bytes;
      done_.push_back(cases[i]);
    }
    LogInfo("{} x {} px: {:.1f} s", size, size, timer.seconds());
  }

  // Counts by the march, the fastest renderer, if a Vulkan device is in use; otherwise by the slow
  // reference, but only if anything is measured.
  void CountSteps(const RadianceField& field, const std::vector<RenderView>& views,
                  std::vector<Case>& cases) const {
    const bool by_march = UsesVulkan(options_);
    const bool all_skipped = std::all_of(cases.begin(), cases.end(), [](const Case& one) {
      return one.row.skipped_seconds.has_value();
    });
    if (!by_march && all_skipped) return;
    const std::vector<double> steps =
        StepsOf(field, views, by_march ? RendererKind::kMarch : RendererKind::kReference,
                options_.renderer);
    const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / double(steps.size());
    for (Case& one : cases) one.row.steps_per_ray = mean / one.row.rays;
  }

  const BenchOptions& options_;
  std::vector<BenchVariant> variants_;
  std::function<std::vector<RenderView>(int size)> views_;
  std::vector<Case> done_;
  std::string device_;
};

}  // namespace

void BenchOptions::Check() const {
  const auto fail = [](const char* option, auto value, const char* want) {
    throw UsageError(fmt::format("{} is {}, must be {}", option, value, want));
  };
  for (uint64_t count : tets) {
    if (count < 1 || count > 100'000'000) fail("tets", count, "1 to 100000000");
  }
  for (int size : sizes) {
    if (size < 8 || size > 8192) fail("size", size, "8 to 8192 px");
  }
  if (repeat < 1) fail("repeat", repeat, "at least 1");
  if (error_size < 8 || error_size > 1024) fail("error_size", error_size, "8 to 1024 px");
  if (!(case_seconds > 0)) fail("case_seconds", case_seconds, "above 0 s");
  if (!(longest_turn > 0)) fail("longest_turn", longest_turn, "above 0 s");
  VariantsOf(*this);
}

bool UsesVulkan(const BenchOptions& options) {
  return std::any_of(options.renderers.begin(), options.renderers.end(),
                     [](const std::string& renderer) { return renderer != "reference"; });
}

std::vector<BenchVariant> VariantsOf(const BenchOptions& options) {
  const auto has_lists = [](const std::string& renderer) {
    return renderer == "ppll" || renderer == "projection";
  };
  const bool any_lists = std::any_of(options.renderers.begin(), options.renderers.end(), has_lists);
  std::vector<BenchVariant> variants;
  for (const std::string& renderer : options.renderers) {
    const bool all = options.all_pairs || renderer == options.renderers.front();
    const bool sorts_tets = renderer == "projection";
    for (const std::string& order : sorts_tets ? options.orders : std::vector<std::string>{""}) {
      for (const std::string& integral : options.integrals) {
        if (!all && integral != options.integrals.back()) continue;
        BenchVariant variant{renderer, order, integral, options.renderer};
        variant.options.kind = FromName<RendererKind>(renderer).value();
        variant.options.integral = ParseIntegral(integral);
        if (sorts_tets) variant.options.order = FromName<VisibilityOrder>(order).value();
        // An option that this renderer does not have is meant for the others; Check refuses it if
        // none of them has it.
        if (!has_lists(renderer) && any_lists)
          variant.options.fragment_memory = RendererOptions().fragment_memory;
        if (renderer == "reference" && UsesVulkan(options)) variant.options.device = {};
        variant.options.Check();
        variants.push_back(std::move(variant));
      }
    }
  }
  return variants;
}

BenchResult RunBench(const BenchOptions& options, const RadianceField* field,
                     const std::vector<RenderView>& views) {
  BenchOptions sorted = options;
  if (field == nullptr && sorted.tets.empty()) sorted.tets = kTetsOfBall;
  std::sort(sorted.sizes.begin(), sorted.sizes.end());
  std::sort(sorted.tets.begin(), sorted.tets.end());
  Bench bench(sorted, [&](int size) {
    if (field == nullptr) return ViewsAroundCube(kViews, size);
    std::vector<RenderView> chosen = SpreadChoice<RenderView>(views, kViews);
    for (RenderView& view : chosen) view = SquareMiddle(view, size);
    return chosen;
  });
  const FieldStorage storage =
      options.storage.value_or(field != nullptr ? field->storage : FieldStorage::kVertex);
  try {
    if (field != nullptr && sorted.tets.empty()) bench.RunOn(WithStorage(*field, storage));
    for (uint64_t tets : sorted.tets) {
      bench.RunOn(WithStorage(
          field != nullptr ? Resample(*field, tets, options.seed) : BallFieldOfTets(tets),
          storage));
    }
  } catch (const Interrupted&) {
    if (bench.Rows().empty()) throw;
  }
  return {bench.device(), field != nullptr ? "field" : "ball in a cube", options, bench.Rows()};
}

BenchResult RunBench(const BenchOptions& options, const std::filesystem::path& field_folder) {
  if (field_folder.empty()) return RunBench(options, nullptr, {});
  ReadManifest(field_folder, {"optimize"});
  const RadianceField field = ReadField(field_folder / "field.tetf");
  const Scene scene = ReadScene(PreviousStage(field_folder, {"sfm", "import"}));
  std::vector<RenderView> views;
  for (const View& view : scene.views)
    views.push_back({scene.cameras[view.camera], view.cam_from_world});
  BenchResult result = RunBench(options, &field, views);
  result.scene = field_folder.string();
  return result;
}

}  // namespace tetrec
