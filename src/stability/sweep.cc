// Runs the sweep over hyperparameters.
#include "stability/sweep.h"

#include "optimize/optimize_options.h"
#include "stability/work_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

using Options = std::vector<std::string>;

// What does not vary. The regulariser has no effect on small steps, so it is swept with larger ones
// than the article's.
constexpr double kArticleRate = 2e-5;    // 1e-5 in the article's box, whose longest side is 0.5
constexpr double kRateOfQuality = 1e-3;  // of positions, while weight or sharpness vary
constexpr double kWeight = 10, kSharpness = 100;

struct Point {
  SweptParameter parameter;
  double value;
};

std::vector<Point> PointsOf(bool is_short) {
  std::vector<Point> points;
  const auto add = [&](SweptParameter parameter, const std::vector<double>& all,
                       const std::vector<double>& few) {
    for (const double value : is_short ? few : all) points.push_back({parameter, value});
  };
  add(SweptParameter::kColorRate, {1e-4, 1e-3, 1e-2, 3e-2, 1e-1, 1}, {0.1});
  add(SweptParameter::kPositionRate, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1}, {1e-5, 1e-1});
  add(SweptParameter::kWeight, {0.1, 1, 10, 100, 1000}, {10});
  add(SweptParameter::kSharpness, {1, 10, 100, 1000, 10000}, {1000});
  return points;
}

std::string Text(double value) { return fmt::format("{:.9g}", value); }

// Safe motion takes the rate as a share of the edges, of which the longest side has as many as the
// grid has cells.
Options MotionOptions(SweptMethod method, double position_rate, int grid_cells) {
  switch (method) {
    case SweptMethod::kFixed:
      return {"--move", "off"};
    case SweptMethod::kSafe:
      return {"--move", "safe", "--position-rate", Text(position_rate * grid_cells)};
    case SweptMethod::kArticle:
      // The article knows no judging pictures, no decay of density or rates, and no sign of
      // density.
      return {"--move",
              "article",
              "--position-rate",
              Text(position_rate),
              "--density",
              "positive",
              "--density-decay",
              "0",
              "--judging-pictures",
              "learned",
              "--final-rate-share",
              "1"};
  }
  TETREC_CHECK(false, "a method of unknown kind");
}

// The rate of positions that the methods use while another parameter varies.
double UsualRate(SweptMethod method, SweptParameter parameter, int grid_cells) {
  if (parameter == SweptParameter::kWeight || parameter == SweptParameter::kSharpness) {
    return kRateOfQuality;
  }
  return method == SweptMethod::kArticle ? kArticleRate : 0.1 / grid_cells;
}

Options OptimizeOptionsOf(const SweepOptions& options, SweptMethod method, const Point& point) {
  const auto value_if = [&](SweptParameter parameter, double otherwise) {
    return point.parameter == parameter ? point.value : otherwise;
  };
  const int cells = options.GridCells();
  const double position_rate =
      value_if(SweptParameter::kPositionRate, UsualRate(method, point.parameter, cells));
  const double color_rate = value_if(SweptParameter::kColorRate, AdamUpdate().color_rate);
  Options words = {"--iterations",
                   std::to_string(options.Steps()),
                   "--time-limit",
                   "0",
                   "--watched-views",
                   "0",
                   "--rounds",
                   "0",
                   "--sh",
                   "0",
                   "--fine-rays",
                   "off",
                   "--background",
                   "scene",
                   "--color-rate",
                   Text(color_rate)};
  if (point.parameter == SweptParameter::kColorRate) {
    words.insert(words.end(), {"--density-rate", Text(color_rate)});
  }
  const Options motion = MotionOptions(method, position_rate, cells);
  words.insert(words.end(), motion.begin(), motion.end());
  if (method != SweptMethod::kFixed) {
    words.insert(words.end(),
                 {"--quality-weight", Text(value_if(SweptParameter::kWeight, kWeight)),
                  "--quality-sharpness", Text(value_if(SweptParameter::kSharpness, kSharpness))});
  }
  return words;
}

std::string FolderName(SweptMethod method, const Point& point) {
  std::string name = fmt::format("{}-{:g}-{}", Name(point.parameter), point.value, Name(method));
  std::ranges::replace_if(
      name, [](char c) { return c == ' ' || c == '\''; }, '-');
  return name;
}

bool SameColorRate(const SweepResult& a, const SweepResult& b) {
  const bool both_swept =
      a.parameter == SweptParameter::kColorRate && b.parameter == SweptParameter::kColorRate;
  if (both_swept) return a.value == b.value;
  return a.parameter != SweptParameter::kColorRate && b.parameter != SweptParameter::kColorRate;
}

void Print(const SweepResult& result) {
  const ChainResult& run = result.run;
  fmt::print("{:<18} {:<8g} {:<17}", Name(result.parameter), result.value, Name(result.method));
  if (run.psnr) fmt::print("{:6.2f} dB", *run.psnr);
  fmt::print(", {} degenerate tets, {:.1f} s", run.degenerate_tets, run.seconds);
  if (run.exit_code != 0) fmt::print(", exit code {}: {}", run.exit_code, run.said);
  fmt::print("\n");
  std::fflush(stdout);
}

}  // namespace

uint64_t SweepOptions::Steps() const {
  if (iterations > 0) return iterations;
  return is_short ? 40 : 300;
}

int SweepOptions::GridCells() const { return is_short ? 6 : 16; }

bool SweepResult::IsBroken() const {
  return run.exit_code != 0 || !run.psnr || run.degenerate_tets > 0;
}

std::vector<SweepResult> UnsafeRuns(const std::vector<SweepResult>& results) {
  std::vector<SweepResult> unsafe;
  for (const SweepResult& safe : results) {
    if (safe.method != SweptMethod::kSafe) continue;
    const auto fixed = std::ranges::find_if(results, [&](const SweepResult& other) {
      return other.method == SweptMethod::kFixed && SameColorRate(safe, other) && other.run.psnr;
    });
    const bool loses = fixed != results.end() && safe.run.psnr &&
                       *fixed->run.psnr - *safe.run.psnr > kLargestSweepLoss_db;
    if (safe.IsBroken() || loses) unsafe.push_back(safe);
  }
  return unsafe;
}

std::vector<SweepResult> RunSweep(const SweepOptions& options, const fs::path& out) {
  fs::path scene = options.scene;
  if (scene.empty()) {
    scene = out / "runs" / "balls";
    WriteSceneStage(SyntheticBalls(options.is_short, options.seed), "import", "none", scene);
  }
  ChainRequest request{
      .programs = options.programs,
      .scene = scene,
      .tetrahedra = {},
      .folder = {},
      .tetrahedralize = {"--start", "grid", "--resolution", std::to_string(options.GridCells())},
      .optimize = {}};
  std::vector<SweepResult> results;
  std::optional<ChainResult> fixed;
  for (const Point& point : PointsOf(options.is_short)) {
    for (const auto& [method, word] : kWords<SweptMethod>) {
      SweepResult result{point.parameter, method, point.value, {}};
      const bool is_shared =
          method == SweptMethod::kFixed && point.parameter != SweptParameter::kColorRate;
      request.folder = out / "runs" / (is_shared ? "vertices-fixed" : FolderName(method, point));
      request.optimize = OptimizeOptionsOf(options, method, point);
      const bool is_known = is_shared && fixed;
      result.run = is_known ? *fixed : RunChain(request);
      if (is_shared) fixed = result.run;
      if (!is_known) Print(result);
      results.push_back(std::move(result));
    }
  }
  return results;
}

}  // namespace tetrec
