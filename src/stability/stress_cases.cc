// The table of stress cases.
#include "stability/stress_cases.h"

#include "optimize/optimize_options.h"
#include "stability/mesh_damage.h"
#include "stability/point_damage.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

using Options = std::vector<std::string>;

Options Steps(uint64_t iterations) {
  return {"--iterations",    std::to_string(std::max<uint64_t>(iterations, 1)),
          "--time-limit",    "0",
          "--watched-views", "0"};
}

Options Joined(Options options, const Options& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

// All learning rates of photos times a factor.
Options Rates(double factor) {
  const OptimizeOptions defaults;
  const FirstRates first = FirstRatesOf(defaults, false);
  Options words;
  const auto add = [&](const char* option, double rate) {
    words.insert(words.end(), {option, fmt::format("{:.9g}", factor * rate)});
  };
  add("--color-rate", first.color);
  add("--density-rate", first.density);
  add("--sh-rate", first.harmonics);
  add("--position-rate", PositionRateOf(defaults));
  return words;
}

class CaseList {
 public:
  explicit CaseList(Options steps) : steps_(std::move(steps)) {}

  // The case, with the usual number of steps where it gives no options.
  StressCase& Add(const std::string& name, const std::string& what) {
    cases_.push_back({.name = name, .what = what, .twin = "clean", .optimize = steps_});
    return cases_.back();
  }
  std::vector<StressCase> Take() { return std::move(cases_); }

 private:
  Options steps_;
  std::vector<StressCase> cases_;
};

void AddRates(CaseList& list, uint64_t iterations) {
  for (const double factor : {0.01, 0.1, 10.0, 100.0, 1000.0}) {
    StressCase& stress = list.Add(fmt::format("rates-x{}", factor),
                                  fmt::format("all learning rates times {:g}", factor));
    stress.optimize = Joined(Steps(iterations), Rates(factor));
    stress.is_short = factor == 0.01 || factor == 1000;
    if (factor < 0.1) stress.gone = "the steps: so small ones do not get there";
  }
}

void AddPhotos(CaseList& list, uint64_t seed) {
  StressCase& few = list.Add("five-photos", "5 training photos only");
  few.damage_scene = [](SceneWithImages& given) { KeepTrainingViews(given, 5); };
  few.gone = "most of what the held-out views show";
  list.Add("photos-twice", "every third photo twice").damage_scene = RepeatEveryThirdView;
  list.Add("turned-camera", "one camera turned by 5 degrees").damage_scene =
      [](SceneWithImages& given) { TurnOneCamera(given, 5); };
  StressCase& black = list.Add("black-photo", "one photo all black");
  black.damage_scene = BlackenOneImage;
  black.is_short = true;
  list.Add("exposed-photo", "one photo's exposure doubled").damage_scene =
      [](SceneWithImages& given) { ExposeOneImage(given, 2); };
  StressCase& blurred = list.Add("blurred-photos", "half of the photos blurred (5x5 px)");
  blurred.damage_scene = [](SceneWithImages& given) { BlurHalfOfImages(given, 2); };
  StressCase& noisy = list.Add("noise", "noise of 5 % in all photos");
  noisy.damage_scene = [seed](SceneWithImages& given) { AddNoise(given, 0.05, seed); };
}

void AddPoints(CaseList& list, uint64_t seed) {
  const auto add = [&](const char* name, const char* what) -> StressCase& {
    StressCase& stress = list.Add(name, what);
    stress.tetrahedralize = {"--start", "points"};
    stress.twin = "clean-points";
    stress.needs_points = true;
    return stress;
  };
  add("clean-points", "start from sparse points").twin = "";
  const auto misplace = [seed](SceneWithImages& given) { MisplacePoints(given.scene, 0.1, seed); };
  StressCase& wrong = list.Add("wrong-points", "10 % of the sparse points wrong");
  wrong.damage_scene = misplace;
  wrong.needs_points = true;
  add("wrong-points-start", "10 % of the sparse points wrong, start from them").damage_scene =
      misplace;
  add("coplanar-points", "all sparse points in a plane").damage_scene = [](SceneWithImages& given) {
    FlattenPoints(given.scene);
  };
  add("coincident-points", "all sparse points in one place").damage_scene =
      [](SceneWithImages& given) { CollapsePoints(given.scene); };
  StressCase& three = add("three-points", "three sparse points");
  three.damage_scene = [](SceneWithImages& given) { KeepPoints(given.scene, 3); };
}

void AddMeshes(CaseList& list, uint64_t iterations) {
  StressCase& huge = list.Add("huge-tet", "one huge tet in the middle of tiny ones");
  huge.damage_start = [](RadianceField& field, const Scene& scene) {
    ReplaceMiddleByOneTet(field, scene.subject_bounds);
  };
  huge.is_short = true;
  StressCase& slivers = list.Add("slivers", "2,000 slivers in the start mesh");
  slivers.damage_start = [](RadianceField& field, const Scene& scene) {
    AddSlivers(field, scene.subject_bounds, 2000);
  };
  slivers.is_short = true;
  StressCase& rounds = list.Add("fifty-rounds", "50 rounds of refinement to 20,000 vertices");
  rounds.optimize = Joined(Steps(iterations), {"--rounds", "50", "--max-vertices", "20000"});
}

void AddLengths(CaseList& list, uint64_t iterations) {
  for (const auto& [factor, name] : {std::pair{1.0 / 16, "a sixteenth"}, {0.25, "a quarter"}}) {
    StressCase& brief =
        list.Add(fmt::format("length-x{:g}", factor), fmt::format("{} of the steps", name));
    brief.optimize = Steps(uint64_t(factor * double(iterations)));
    brief.gone = "the steps";
  }
  for (const uint64_t factor : {4, 10}) {
    list.Add(fmt::format("length-x{}", factor), fmt::format("{} times the steps", factor))
        .optimize = Steps(factor * iterations);
  }
}

}  // namespace

std::vector<StressCase> StressCases(uint64_t iterations, uint64_t seed) {
  CaseList list(Steps(iterations));
  StressCase& clean = list.Add("clean", "nothing damaged");
  clean.twin = "";
  clean.is_short = true;
  AddRates(list, iterations);
  AddPhotos(list, seed);
  AddPoints(list, seed);
  AddMeshes(list, iterations);
  AddLengths(list, iterations);
  return list.Take();
}

}  // namespace tetrec
