// Runs the stress cases one after another.
#include "stability/stress.h"

#include "core/error.h"
#include "core/file.h"
#include "core/manifest.h"
#include "core/stage_input.h"
#include "core/stage_run.h"
#include "mesh/tet_io.h"
#include "stability/work_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Exit code 3 is for input that is refused. Options (2) and the machine (4) are not what is tested.
bool IsRefusal(const ChainResult& run) { return run.exit_code == 3 && !run.said.empty(); }

// The cases that were asked for, with their twins.
std::vector<StressCase> ChosenCases(const StressOptions& options) {
  std::set<std::string> names(options.cases.begin(), options.cases.end());
  const std::vector<StressCase> all = StressCases(options.Steps(), options.seed);
  for (const StressCase& stress : all) {
    const bool chosen = options.cases.empty() && (stress.is_short || !options.is_short);
    if (chosen) names.insert(stress.name);
    if (names.contains(stress.name) && !stress.twin.empty()) names.insert(stress.twin);
  }
  std::vector<StressCase> cases;
  std::ranges::copy_if(all, std::back_inserter(cases),
                       [&](const StressCase& stress) { return names.contains(stress.name); });
  return cases;
}

// The start of the twin, damaged, as a folder of tetrec-tetrahedralize.
void WriteDamagedStart(const StressCase& stress, const Scene& scene, const fs::path& clean_start,
                       const fs::path& scene_folder, const fs::path& folder) {
  const StageInput input = ReadStageInput("scene", scene_folder, {"sfm", "import"}, folder);
  const StageRequest request = {
      .stage = "tetrahedralize",
      .folder = folder,
      .options = {{"damage", stress.name}},
      .options_with_effect = {{"damage", stress.name},
                              {"start", Sha256OfFile(clean_start / "field.tetf")}},
      .inputs = {input},
      .command_line = "tetrec-stability"};
  RunStage(request, [&](Stage& stage) {
    RadianceField field = ReadField(clean_start / "field.tetf");
    stress.damage_start(field, scene);
    WriteTetMesh(stage.Output("mesh.tet"), field.mesh);
    WriteField(stage.Output("field.tetf"), field);
  });
}

// Writes the damaged start, or returns why the start cannot be damaged so.
std::string WhyNotDamaged(const StressCase& stress, const Scene& scene, const fs::path& clean_start,
                          const fs::path& scene_folder, const fs::path& folder) {
  try {
    WriteDamagedStart(stress, scene, clean_start, scene_folder, folder);
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

std::string Line(const StressResult& result) {
  std::string line = fmt::format("{:<20} {:<17}", result.name, Name(result.verdict));
  if (result.run.psnr) line += fmt::format("{:6.2f} dB", *result.run.psnr);
  if (result.lost_db) line += fmt::format(" (lost {:.2f})", *result.lost_db);
  if (result.run.exit_code != 0) line += fmt::format(" exit code {}", result.run.exit_code);
  if (!result.run.said.empty()) line += "  " + result.run.said;
  return line;
}

}  // namespace

void StressOptions::Check() const {
  const std::vector<StressCase> all = StressCases(Steps(), seed);
  for (const std::string& name : cases) {
    if (std::ranges::find(all, name, &StressCase::name) != all.end()) continue;
    std::vector<std::string> names;
    for (const StressCase& stress : all) names.push_back(stress.name);
    throw UsageError(fmt::format("case: there is no case '{}'; expected some of {}", name,
                                 fmt::join(names, ", ")));
  }
}

uint64_t StressOptions::Steps() const {
  if (iterations > 0) return iterations;
  return is_short ? 60 : 400;
}

Verdict Judge(const ChainResult& run, const ChainResult* twin, bool information_is_gone) {
  if (twin != nullptr && IsRefusal(run)) return Verdict::kRefused;
  if (run.exit_code != 0 || !run.psnr || run.degenerate_tets > 0) return Verdict::kBreaks;
  if (twin == nullptr) return *run.psnr < kLeastOfClean_db ? Verdict::kBreaks : Verdict::kClean;
  if (!twin->psnr) return Verdict::kSkipped;
  if (*twin->psnr - *run.psnr <= kLargestLoss_db) return Verdict::kHolds;
  return information_is_gone ? Verdict::kExcused : Verdict::kBreaks;
}

std::vector<StressResult> RunStress(const StressOptions& options, const fs::path& out) {
  const SceneWithImages clean = options.scene.empty()
                                    ? SyntheticRoom(options.is_short, options.seed)
                                    : ReadSceneWithImages(options.scene);
  const std::string first_stage = options.scene.empty() ? "sfm" : FirstStageOf(options.scene);
  const fs::path clean_scene = out / "runs" / "scene";
  WriteSceneStage(clean, first_stage, "clean", clean_scene);
  std::map<std::string, ChainResult> done;
  std::vector<StressResult> results;
  for (const StressCase& stress : ChosenCases(options)) {
    StressResult result{.name = stress.name,
                        .what = stress.what,
                        .twin = stress.twin,
                        .gone = stress.gone,
                        .run = {},
                        .lost_db = {}};
    const ChainResult* twin = stress.twin.empty() ? nullptr : &done[stress.twin];
    const bool has_start = !stress.damage_start || (twin != nullptr && twin->psnr);
    if ((stress.needs_points && clean.scene.points.empty()) || !has_start) {
      result.run.said = has_start ? "the scene has no sparse points" : "the clean twin failed";
    } else {
      ChainRequest request{.programs = options.programs,
                           .scene = clean_scene,
                           .tetrahedra = {},
                           .folder = out / "runs" / stress.name,
                           .tetrahedralize = stress.tetrahedralize,
                           .optimize = stress.optimize};
      if (stress.damage_scene) {
        SceneWithImages damaged = clean;
        stress.damage_scene(damaged);
        request.scene = request.folder / "1_scene";
        WriteSceneStage(damaged, first_stage, stress.name, request.scene);
      }
      std::string why_not;
      if (stress.damage_start) {
        request.tetrahedra = request.folder / "2_tetrahedra";
        why_not = WhyNotDamaged(stress, clean.scene, out / "runs" / stress.twin / "2_tetrahedra",
                                clean_scene, request.tetrahedra);
      }
      if (why_not.empty()) {
        result.run = RunChain(request);
        result.verdict = Judge(result.run, twin, !stress.gone.empty());
      } else {
        result.run.said = why_not;
      }
      if (twin != nullptr && twin->psnr && result.run.psnr) {
        result.lost_db = *twin->psnr - *result.run.psnr;
      }
    }
    done[stress.name] = result.run;
    fmt::print("{}\n", Line(result));
    std::fflush(stdout);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace tetrec
