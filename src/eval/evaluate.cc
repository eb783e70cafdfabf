// The evaluation stage.
#include "eval/evaluate.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "eval/image_metrics.h"
#include "eval/mesh_preview.h"
#include "eval/metrics_csv.h"
#include "eval/plot.h"
#include "eval/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

void Warn(std::vector<std::string>& warnings, std::string warning) {
  LogWarning("{}", warning);
  warnings.push_back(std::move(warning));
}

Image ReadRgb(const fs::path& path) {
  Image image = ReadImage(path);
  if (image.channels != 3) {
    throw DataError(fmt::format("{}: has {} channels; expected RGB, composited over the background",
                                path.string(), image.channels));
  }
  return image;
}

ViewScore ScoreView(const RenderedView& view) {
  const Image render = ReadRgb(view.render), truth = ReadRgb(view.truth);
  if (render.width != truth.width || render.height != truth.height) {
    throw DataError(fmt::format("{} is {}x{} px but {} is {}x{}", view.render.string(),
                                render.width, render.height, view.truth.string(), truth.width,
                                truth.height));
  }
  ViewScore score;
  score.name = view.name;
  if (view.seen) {
    const Image seen = ReadImage(*view.seen);
    const auto mse = MaskedMeanSquaredError(render, truth, seen);
    if (!mse) {
      throw DataError(fmt::format("{}: is black: nothing of the view {} is to be judged",
                                  view.seen->string(), view.name));
    }
    score.mse = *mse;
    score.ssim = MaskedSsim(render, truth, seen).value();
  } else {
    score.mse = MeanSquaredError(render, truth);
    score.ssim = Ssim(render, truth);
  }
  score.psnr = PsnrFromMse(score.mse);
  if (view.mask) {
    const auto mse = MaskedMeanSquaredError(render, truth, ReadImage(*view.mask));
    if (mse) score.foreground_psnr = PsnrFromMse(*mse);
  }
  return score;
}

std::vector<ViewScore> ScoreViews(const RenderedViews& rendered) {
  std::vector<ViewScore> scores(rendered.views.size());
  ParallelFor(scores.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      ThrowIfStopRequested("nothing was written");
      scores[i] = ScoreView(rendered.views[i]);
    }
  });
  return scores;
}

// JSON knows no infinity.
json Finite(double value) { return std::isfinite(value) ? json(value) : json(); }
json Finite(const std::optional<double>& value) { return value ? Finite(*value) : json(); }

template <class Get>
double MeanOf(const std::vector<ViewScore>& scores, Get get) {
  double sum = 0;
  for (const ViewScore& score : scores) sum += get(score);
  return sum / double(scores.size());
}

json ImageMetrics(const RenderedViews& rendered, const std::vector<ViewScore>& scores) {
  json views = json::array();
  double foreground_sum = 0;
  size_t foreground_count = 0, identical = 0;
  for (const ViewScore& score : scores) {
    views.push_back({{"name", score.name},
                     {"psnr", Finite(score.psnr)},
                     {"ssim", score.ssim},
                     {"mse", score.mse},
                     {"foreground_psnr", Finite(score.foreground_psnr)}});
    identical += score.mse == 0;
    if (!score.foreground_psnr) continue;
    foreground_sum += *score.foreground_psnr;
    ++foreground_count;
  }
  const double mean_mse = MeanOf(scores, [](const ViewScore& s) { return s.mse; });
  // Views of which only the pixels that a mask leaves are judged.
  const auto masked_count = std::count_if(rendered.views.begin(), rendered.views.end(),
                                          [](const RenderedView& view) { return bool(view.seen); });
  // No mask anywhere: 0 / 0, which Finite writes as null.
  const double mean_foreground = foreground_sum / double(foreground_count);
  return {
      {"schema", 1},
      {"psnr", Finite(MeanOf(scores, [](const ViewScore& s) { return s.psnr; }))},
      {"psnr_of_mean_mse", Finite(PsnrFromMse(mean_mse))},
      {"foreground_psnr", Finite(mean_foreground)},
      {"foreground_views", foreground_count},
      {"masked_views", masked_count},
      {"identical_views", identical},
      {"ssim", MeanOf(scores, [](const ViewScore& s) { return s.ssim; })},
      {"ssim_window", "gaussian 11x11 sigma 1.5, K 0.01 0.03, range 1, zero padding, mean of RGB"},
      {"lpips", nullptr},
      {"views", std::move(views)},
      {"resolution", {rendered.width, rendered.height}},
      {"background", rendered.background},
      {"rays_per_pixel", rendered.rays_per_pixel},
      {"split", rendered.split}};
}

// Size of the field's own file among the optimiser's outputs.
json FieldBytes(const StageFacts& optimize) {
  uint64_t bytes = 0;
  for (const json& output : optimize.manifest.value("outputs", json::array())) {
    if (!output.is_object()) continue;
    const std::string path = output.value("path", "");
    if (fs::path(path).parent_path().empty() && fs::path(path).stem() == "field") {
      bytes += output.value("bytes", uint64_t{0});
    }
  }
  return bytes > 0 ? json(bytes) : json();
}

json RunMetrics(const RunFacts& run) {
  json seconds = json::object();
  for (const char* stage : {"sfm", "tetrahedralize", "optimize", "render", "surface"}) {
    seconds[stage] = nullptr;
  }
  uint64_t peak = 0;
  json device, seed;
  for (const StageFacts& stage : run.stages) {
    seconds[stage.stage] = stage.Seconds();
    peak = std::max(peak, stage.PeakRssBytes());
    if (const std::string name = stage.Device(); !name.empty()) device = name;
  }
  const StageFacts* optimize = run.Find("optimize");
  if (optimize) seed = optimize->manifest.value("seed", json());
  return {{"tets", optimize ? optimize->Count("tets") : json()},
          {"vertices", optimize ? optimize->Count("vertices") : json()},
          {"field_bytes", optimize ? FieldBytes(*optimize) : json()},
          {"seconds", std::move(seconds)},
          {"peak_rss_bytes", peak},
          {"device", std::move(device)},
          {"seed", std::move(seed)},
          {"git", run.stages.back().manifest.value("git", json())}};
}

// The one PLY among the stage's outputs, or surface.ply.
std::string SurfaceFile(const StageFacts& surface) {
  std::vector<std::string> files;
  for (const json& output : surface.manifest.value("outputs", json::array())) {
    const std::string path = output.is_object() ? output.value("path", "") : "";
    if (fs::path(path).extension() == ".ply") files.push_back(path);
  }
  if (files.size() == 1) return files[0];
  if (std::count(files.begin(), files.end(), "surface.ply") == 1) return "surface.ply";
  throw DataError(
      fmt::format("{}: has {} PLY files and none is surface.ply; run tetrec-surface again",
                  surface.folder.string(), files.size()));
}

// Up is where the pictures' upper edges point to, on average.
glm::dvec3 UpInWorld(const Scene& scene) {
  glm::dvec3 up(0.0);
  for (const View& view : scene.views) {
    up += glm::transpose(view.cam_from_world.rotation) * glm::dvec3(0, -1, 0);
  }
  // Cameras from all sides, upside down too, tell nothing: then z.
  const double length = glm::length(up);
  return length > 0.05 * double(scene.views.size()) ? up / length : glm::dvec3(0, 0, 1);
}

void DrawPreviews(const TriangleMesh& mesh_in_input, const Scene& scene, SurfaceResult& result) {
  const TriangleMesh mesh = Transformed(mesh_in_input, scene.input_from_world.Inverse());
  PreviewOptions options;
  options.up = UpInWorld(scene);
  for (const glm::vec3& position : mesh.positions) options.bounds.Add(glm::dvec3(position));
  const Bounds3 subject = scene.subject_bounds.Scaled(1.1);
  const Bounds3 common{glm::max(options.bounds.min, subject.min),
                       glm::min(options.bounds.max, subject.max)};
  if (!common.IsEmpty()) options.bounds = common;
  if (options.bounds.IsEmpty()) return;  // no vertex: nothing to show
  options.bounds = options.bounds.Scaled(1.0001);
  if (mesh.colors_srgb.size() == mesh.positions.size()) {
    result.color_pictures = RenderTurntable(mesh, options);
  }
  options.use_colors = false;
  result.clay_pictures = RenderTurntable(mesh, options);
}

void CompareWithTruth(const TriangleMesh& mesh_in_input, const std::optional<Scene>& scene,
                      const EvaluateOptions& options, const Stage& stage, SurfaceResult& result,
                      std::vector<std::string>& warnings) {
  TriangleMesh mesh_in_truth = mesh_in_input;
  if (stage.HasInput("cameras")) {
    if (!scene) throw DataError("--cameras needs the scene folder of the run, which is gone");
    result.alignment = AlignByCameras(*scene, ReadTrueCameras(stage.Input("cameras")));
    const Alignment& alignment = *result.alignment;
    LogInfo(
        "alignment: {} cameras, centres off by {:.4g} rms ({:.3f} % of their spread), {:.3f} "
        "degrees",
        alignment.matched, alignment.center_rms,
        100 * alignment.center_rms / alignment.center_spread, alignment.rotation_mean_deg);
    if (!alignment.unmatched.empty()) {
      Warn(warnings, fmt::format("{} of {} views have no true camera and do not take part in the "
                                 "alignment, first '{}'",
                                 alignment.unmatched.size(), scene->views.size(),
                                 alignment.unmatched.front()));
    }
    if (alignment.rotation_mean_deg > 2) {
      Warn(warnings,
           fmt::format("after alignment cameras look {:.1f} degrees past the true ones on "
                       "average: the surface's scores are not to be trusted",
                       alignment.rotation_mean_deg));
    }
    mesh_in_truth = Transformed(mesh_in_input, alignment.truth_from_input);
  }
  SurfaceScoreOptions score_options;
  score_options.threshold = options.threshold_percent / 100;
  score_options.samples = options.surface_samples;
  score_options.seed = options.seed;
  if (const auto& b = options.ground_truth_bounds; !b.empty()) {
    score_options.bounds = Bounds3{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
  }
  const TriangleMesh truth = ReadTriangleMesh(stage.Input("ground-truth"));
  result.scores = CompareSurfaces(mesh_in_truth, truth, score_options);
  LogInfo("surface: F-score {:.4f} (precision {:.4f}, recall {:.4f}) at {:.4g}, diagonal {:.4g}",
          result.scores->f_score, result.scores->precision, result.scores->recall,
          result.scores->threshold, result.scores->diagonal);
}

json Vector(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

json AlignmentJson(const Alignment& a) {
  json rotation = json::array();
  for (int r = 0; r < 3; ++r) {
    const glm::dmat3& m = a.truth_from_input.rotation;
    rotation.push_back({m[0][r], m[1][r], m[2][r]});
  }
  return {{"scale", a.truth_from_input.scale},
          {"rotation", std::move(rotation)},
          {"translation", Vector(a.truth_from_input.translation)},
          {"matched_views", a.matched},
          {"unmatched_views", a.unmatched},
          {"center_rms", a.center_rms},
          {"center_max", a.center_max},
          {"center_spread", a.center_spread},
          {"rotation_mean_deg", a.rotation_mean_deg},
          {"rotation_max_deg", a.rotation_max_deg}};
}

json ScoresJson(const SurfaceScores& s, const EvaluateOptions& options) {
  return {
      {"f_score", s.f_score},
      {"precision", s.precision},
      {"recall", s.recall},
      {"accuracy", Finite(s.accuracy)},
      {"completeness", Finite(s.completeness)},
      {"chamfer", Finite(s.chamfer)},
      {"threshold", s.threshold},
      {"threshold_percent_of_diagonal", options.threshold_percent},
      {"diagonal", s.diagonal},
      {"bounds_min", Vector(s.crop.min)},
      {"bounds_max", Vector(s.crop.max)},
      {"bounds_from", options.ground_truth_bounds.empty() ? "the truth's bounding box grown by 5 %"
                                                          : "--ground-truth-bounds"},
      {"reconstruction_samples", s.reconstruction_samples},
      {"ground_truth_samples", s.truth_samples}};
}

json SurfaceJson(const SurfaceResult& surface, const EvaluateOptions& options) {
  const MeshFacts& facts = surface.facts;
  json result = {{"file", surface.file},
                 {"faces", facts.faces},
                 {"vertices", facts.vertices},
                 {"components", facts.components},
                 {"watertight", facts.watertight},
                 {"boundary_edges", facts.boundary_edges},
                 {"non_manifold_edges", facts.non_manifold_edges},
                 {"area", facts.area},
                 {"volume", facts.watertight ? json(facts.volume) : json()},
                 {"ground_truth", nullptr},
                 {"alignment", nullptr}};
  if (surface.scores) result["ground_truth"] = ScoresJson(*surface.scores, options);
  if (surface.alignment) result["alignment"] = AlignmentJson(*surface.alignment);
  return result;
}

SurfaceResult JudgeSurface(const EvaluateOptions& options, const std::optional<Scene>& scene,
                           const StageFacts& surface_stage, const Stage& stage,
                           std::vector<std::string>& warnings) {
  SurfaceResult result;
  result.file = SurfaceFile(surface_stage);
  const TriangleMesh mesh = ReadTriangleMesh(surface_stage.folder / result.file);
  result.facts = MeasureMesh(mesh);
  LogInfo("surface: {} triangles, {} components, {}", WithThousands(result.facts.faces),
          WithThousands(result.facts.components),
          result.facts.watertight ? "watertight" : "not watertight");
  if (mesh.triangles.empty()) Warn(warnings, "the surface has no triangle");
  if (scene) DrawPreviews(mesh, *scene, result);
  if (stage.HasInput("ground-truth"))
    CompareWithTruth(mesh, scene, options, stage, result, warnings);
  return result;
}

std::vector<Plot> ConvergencePlots(const std::vector<MetricsRow>& rows) {
  PlotSeries train{"training batches", {}, {}, 5, false, false};
  PlotSeries held_out{"held-out views", {}, {}, 1, false, true};
  PlotSeries loss{"loss (left)", {}, {}, 0, false, false},
      tets{"tets (right)", {}, {}, 2, true, false};
  for (const MetricsRow& row : rows) {
    const auto add = [&](PlotSeries& series, double y) {
      series.x.push_back(row.seconds);
      series.y.push_back(y);
    };
    add(train, row.train_psnr);
    add(loss, row.loss);
    add(tets, row.tets);
    if (row.heldout_psnr) add(held_out, *row.heldout_psnr);
  }
  Plot psnr;
  psnr.title = "PSNR while optimising";
  psnr.x_label = "seconds of optimisation";
  psnr.y_label = "PSNR [dB]";
  psnr.height_px = 400;
  psnr.series = {train, held_out};
  Plot size = psnr;
  size.title = "Loss and number of tets";
  size.y_label = "loss (log)";
  size.y2_label = "tets";
  size.log_y = true;
  size.series = {loss, tets};
  return {psnr, size};
}

// The curves are a convenience: a run without gnuplot or metrics.csv still gets its report, which
// says why they are missing.
void DrawConvergence(const RunFacts& run, Stage& stage, ReportContent& content) {
  const StageFacts* optimize = run.Find("optimize");
  try {
    if (!optimize) throw DataError("the optimiser's folder is gone");
    const auto rows = ReadMetricsCsv(optimize->folder / "metrics.csv");
    const fs::path scratch = stage.Scratch("gnuplot");
    for (const Plot& plot : ConvergencePlots(rows)) {
      const fs::path svg = scratch / "curve.svg";
      DrawPlot(plot, svg, scratch);
      content.curves_svg.push_back(ReadText(svg));
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& error) {
    content.no_curves_reason = error.what();
    Warn(content.warnings, fmt::format("no convergence curves: {}", error.what()));
  }
}

std::string DatasetOf(const RunFacts& run) {
  const StageFacts* scene = run.Scene();
  if (scene) {
    for (const json& input : scene->manifest.value("inputs", json::array())) {
      const fs::path path = input.is_object() ? input.value("path", "") : "";
      // .../demo/photos says more than photos.
      const std::string name = path.filename().string(),
                        above = path.parent_path().filename().string();
      const bool plain = name == "photos" || name == "images" || name == "input";
      if (!name.empty())
        return plain && !above.empty() && above != ".." ? above + "/" + name : name;
    }
  }
  return run.stages.front().folder.filename().string();
}

std::optional<Scene> SceneOf(const RunFacts& run) {
  const StageFacts* stage = run.Scene();
  if (!stage) return std::nullopt;
  return ReadScene(stage->folder);
}

}  // namespace

void EvaluateOptions::Check() const {
  if (!(threshold_percent > 0) || threshold_percent > 100) {
    throw UsageError(
        fmt::format("--threshold is {}; expected more than 0 and at most 100 [% of the "
                    "diagonal]",
                    threshold_percent));
  }
  if (surface_samples < 1000 || surface_samples > 50'000'000) {
    throw UsageError(
        fmt::format("--surface-samples is {}; expected 1,000 to 50,000,000", surface_samples));
  }
  const auto& b = ground_truth_bounds;
  if (!b.empty() && !(b.size() == 6 && b[0] < b[3] && b[1] < b[4] && b[2] < b[5])) {
    throw UsageError(
        "--ground-truth-bounds must be XMIN YMIN ZMIN XMAX YMAX ZMAX, each least below its "
        "most");
  }
}

void Evaluate(const EvaluateOptions& options, Stage& stage) {
  ReportContent content;
  content.rendered = ReadRenderedViews(stage.Input("VIEWS"));
  content.run = ReadRunFacts(stage.Input("VIEWS"));
  for (const std::string& warning : content.run.warnings) Warn(content.warnings, warning);
  content.dataset = DatasetOf(content.run);
  const std::optional<Scene> scene = SceneOf(content.run);

  const Timer views_timer;
  content.scores = ScoreViews(content.rendered);
  stage.Seconds("views", views_timer.seconds());
  json metrics = ImageMetrics(content.rendered, content.scores);
  LogInfo(
      "{} views of the {} split: PSNR {} dB, SSIM {:.4f}", content.scores.size(),
      content.rendered.split,
      metrics["psnr"].is_null() ? "infinite" : fmt::format("{:.3f}", metrics["psnr"].get<double>()),
      metrics["ssim"].get<double>());
  if (metrics["identical_views"] > 0) {
    Warn(content.warnings,
         fmt::format(
             "{} views equal their ground truth to the bit: their PSNR is infinite and the mean "
             "is not given",
             metrics["identical_views"].get<size_t>()));
  }

  if (stage.HasInput("SURFACE")) {
    const Timer timer;
    AddStage(stage.Input("SURFACE"), content.run);
    content.surface =
        JudgeSurface(options, scene, content.run.stages.back(), stage, content.warnings);
    stage.Seconds("surface", timer.seconds());
  }
  metrics.update(RunMetrics(content.run));
  metrics["surface"] = content.surface ? SurfaceJson(*content.surface, options) : json();
  DrawConvergence(content.run, stage, content);

  metrics["warnings"] = content.warnings;
  content.metrics = metrics;
  WriteJson(stage.Output("metrics.json"), metrics);
  const std::string report = MakeReport(content);
  WriteText(stage.Output("report.html"), report);
  stage.Count("views", content.scores.size());
  stage.Count("report_bytes", report.size());
  LogInfo("report: {} ({:.1f} MiB)", (stage.folder() / "report.html").string(),
          double(report.size()) / (1 << 20));
}

}  // namespace tetrec
