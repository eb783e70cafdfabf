// Runs the stages from a scene to its held-out views.
#include "stability/chain.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/manifest.h"
#include "core/timer.h"
#include "eval/run_facts.h"
#include "field/radiance_field.h"
#include "image/psnr.h"
#include "run/rendered_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// The error that ended a stage: its last line that starts with the program's name, or the last line
// of all, as crashes print it.
std::string ErrorIn(const std::vector<std::string>& lines, const std::string& program) {
  for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
    if (line->starts_with(program + ": ")) return *line;
  }
  return lines.empty() ? "" : lines.back();
}

// True if the stage succeeded; otherwise `result` has what is known.
bool RunStageOf(const ChainRequest& request, const std::string& stage, const fs::path& input,
                const fs::path& output, std::vector<std::string> options, ChainResult& result) {
  const std::string name = ProgramOf(stage);
  const fs::path program = request.programs / name;
  if (!fs::exists(program)) {
    throw EnvironmentError(program.string() + " does not exist: build all stages");
  }
  options.insert(options.begin(), {input.string(), "-o", output.string()});
  ChildOptions child;
  child.log = request.folder / (stage + ".log");
  child.time_limit_s = request.time_limit_s;
  const Timer timer;
  try {
    const ChildResult done = RunChild(program, options, child);
    result.exit_code = done.exit_code;
    if (done.exit_code != 0) result.said = ErrorIn(done.last_lines, name);
  } catch (const EnvironmentError& error) {
    result.exit_code = kTookTooLong;
    result.said = error.what();
  }
  if (stage == "optimize") result.seconds = timer.seconds();
  if (result.exit_code != 0) result.failed_stage = stage;
  return result.exit_code == 0;
}

void TakeManifest(const fs::path& folder, ChainResult& result) {
  const json manifest = ReadManifestOrStatus(folder / kManifestFile);
  if (!manifest.is_object()) return;
  const StageFacts facts{manifest["stage"], folder, manifest};
  const std::vector<std::string> warnings = facts.Warnings();
  if (!warnings.empty()) result.said = "warning: " + warnings.back();
  // A stage that was up to date took its time in an earlier run.
  if (facts.stage == "optimize") result.seconds = facts.Seconds();
}

// The article's motion may leave tets inside out.
void MeasureField(const fs::path& path, ChainResult& result) {
  const TetMesh mesh = ReadField(path, Orientations::kAny).mesh;
  result.tets = mesh.tets.size();
  result.vertices = mesh.positions.size();
  result.min_radius_ratio = MeasureQuality(mesh).min_radius_ratio;
  result.degenerate_tets = CountDegenerateTets(mesh);
}

void MeasureViews(const fs::path& path, ChainResult& result) {
  double sum = 0, worst = kPsnrCap_db;
  size_t count = 0;
  for (const RenderedView& view : ReadRenderedViews(path).views) {
    const Image render = ReadImage(view.render), truth = ReadImage(view.truth);
    const std::optional<double> error =
        view.seen ? MaskedMeanSquaredError(render, truth, ReadImage(*view.seen))
                  : MeanSquaredError(render, truth);
    if (!error) continue;
    const double psnr = CappedPsnrFromMse(*error);
    sum += psnr;
    worst = std::min(worst, psnr);
    ++count;
  }
  if (count == 0) return;
  result.psnr = sum / double(count);
  result.worst_psnr = worst;
}

}  // namespace

ChainResult RunChain(const ChainRequest& request) {
  fs::create_directories(request.folder);
  ChainResult result;
  fs::path tetrahedra = request.tetrahedra;
  if (tetrahedra.empty()) {
    tetrahedra = request.folder / "2_tetrahedra";
    if (!RunStageOf(request, "tetrahedralize", request.scene, tetrahedra, request.tetrahedralize,
                    result)) {
      return result;
    }
    TakeManifest(tetrahedra, result);
  }
  const fs::path field = request.folder / "3_field", views = request.folder / "4_views";
  if (!RunStageOf(request, "optimize", tetrahedra, field, request.optimize, result)) return result;
  TakeManifest(field, result);
  MeasureField(field / "field.tetf", result);
  if (!RunStageOf(request, "render", field, views, {"--refine-cameras", "off"}, result)) {
    return result;
  }
  TakeManifest(views, result);
  MeasureViews(views / kRenderedViewsFile, result);
  return result;
}

json JsonOf(const ChainResult& result) {
  const auto number = [](const std::optional<double>& value) {
    return value ? json(*value) : json();
  };
  return {{"exit_code", result.exit_code},
          {"failed_stage", result.failed_stage.empty() ? json() : json(result.failed_stage)},
          {"said", result.said},
          {"seconds", result.seconds},
          {"psnr", number(result.psnr)},
          {"worst_psnr", number(result.worst_psnr)},
          {"tets", result.tets},
          {"vertices", result.vertices},
          {"degenerate_tets", result.degenerate_tets},
          {"min_radius_ratio", result.min_radius_ratio}};
}

}  // namespace tetrec
