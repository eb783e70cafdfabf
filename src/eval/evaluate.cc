// The evaluation stage: scores of views, metrics.json, and the content of the report.
#include "eval/evaluate.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "eval/color_correction.h"
#include "eval/evaluate_depth.h"
#include "eval/evaluate_normals.h"
#include "eval/evaluate_surface.h"
#include "eval/growth_plot.h"
#include "eval/image_metrics.h"
#include "eval/metrics_json.h"
#include "eval/plot.h"
#include "eval/quality_warnings.h"
#include "eval/report.h"
#include "image/psnr.h"
#include "run/camera_corrections.h"
#include "run/mesh_growth.h"
#include "run/photo_exposures.h"
#include "run/rendered_views.h"
#include "run/training_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

Image ReadRgb(const fs::path& path) {
  Image image = ReadImage(path);
  if (image.channels != 3) {
    throw DataError(fmt::format("{}: has {} channels; expected RGB, composited over the background",
                                path.string(), image.channels));
  }
  return image;
}

Image ReadRenderOf(const fs::path& path, const RenderedView& view, const Image& truth) {
  Image render = ReadRgb(path);
  if (render.width != truth.width || render.height != truth.height) {
    throw DataError(fmt::format("{} is {}x{} px but {} is {}x{}", path.string(), render.width,
                                render.height, view.truth.string(), truth.width, truth.height));
  }
  return render;
}

// `seen` may be null; its view has pixels to score.
void ScoreRefined(const RenderedView& view, const Image& truth, const Image* seen,
                  ViewScore& score) {
  if (!view.refined) return;
  const Image render = ReadRenderOf(*view.refined, view, truth);
  const double mse =
      seen ? MaskedMeanSquaredError(render, truth, *seen).value() : MeanSquaredError(render, truth);
  score.refined_psnr = PsnrFromMse(mse);
  score.refined_shift_px = view.refined_shift_px;
  if (const auto halves = ScoreHalves(render, truth, seen)) {
    score.refined_corrected_psnr = PsnrFromMse(halves->corrected_mse);
  }
}

ViewScore ScoreView(const RenderedView& view) {
  const Image truth = ReadRgb(view.truth), render = ReadRenderOf(view.render, view, truth);
  ViewScore score;
  score.name = view.name;
  score.width = truth.width;
  score.height = truth.height;
  const Image seen = view.seen ? ReadImage(*view.seen) : Image{};
  if (view.seen) {
    const auto mse = MaskedMeanSquaredError(render, truth, seen);
    if (!mse) {
      throw DataError(fmt::format("{}: is black, which leaves no pixel of view {} to score",
                                  view.seen->string(), view.name));
    }
    score.mse = *mse;
    score.ssim = MaskedSsim(render, truth, seen).value();
  } else {
    score.mse = MeanSquaredError(render, truth);
    score.ssim = Ssim(render, truth);
  }
  score.psnr = PsnrFromMse(score.mse);
  score.render_contrast = Contrast(render, view.seen ? &seen : nullptr);
  score.truth_contrast = Contrast(truth, view.seen ? &seen : nullptr);
  if (const auto halves = ScoreHalves(render, truth, view.seen ? &seen : nullptr)) {
    score.right_half_psnr = PsnrFromMse(halves->raw_mse);
    score.corrected_psnr = PsnrFromMse(halves->corrected_mse);
  }
  ScoreRefined(view, truth, view.seen ? &seen : nullptr, score);
  if (view.mask) {
    const auto mse = MaskedMeanSquaredError(render, truth, ReadImage(*view.mask));
    if (mse) score.foreground_psnr = PsnrFromMse(*mse);
  }
  return score;
}

std::vector<ViewScore> ScoreViews(const RenderedViews& rendered) {
  std::vector<ViewScore> scores(rendered.views.size());
  ParallelForEach(scores.size(), "", "nothing was written",
                  [&](size_t i) { scores[i] = ScoreView(rendered.views[i]); });
  return scores;
}

template <class Get>
double MeanOf(const std::vector<ViewScore>& scores, Get get) {
  double sum = 0;
  for (const ViewScore& score : scores) sum += get(score);
  return sum / double(scores.size());
}

// The mean over the views that have the value; null if none has.
json MeanOfKnown(const std::vector<ViewScore>& scores, std::optional<double> ViewScore::*value) {
  double sum = 0;
  size_t count = 0;
  for (const ViewScore& score : scores) {
    if (!(score.*value)) continue;
    sum += *(score.*value);
    ++count;
  }
  return count > 0 ? Finite(sum / double(count)) : json();
}

constexpr const char* kCorrectedProtocol =
    "gain and offset per channel fitted by least squares on the left half of each view "
    "(8-bit display sRGB), applied to the right half, clipped and rounded to 8 bits, and judged "
    "there; psnr_right_half judges the same pixels without correction; psnr is of whole views "
    "without correction";

constexpr const char* kRefinedProtocol =
    "six numbers of each view's pose fitted, with the field as it is, to about 4,096 pixels of the "
    "true image (gain and offset per channel fitted beside them), then the whole view is rendered "
    "and judged like psnr, without colour correction; "
    "psnr_refined_cameras_color_corrected judges it like psnr_color_corrected";

json ImageMetrics(const RenderedViews& rendered, const std::vector<ViewScore>& scores) {
  json views = json::array();
  double foreground_sum = 0;
  size_t foreground_count = 0, identical = 0;
  for (const ViewScore& score : scores) {
    views.push_back({{"name", score.name},
                     {"psnr", Finite(score.psnr)},
                     {"ssim", score.ssim},
                     {"mse", score.mse},
                     {"width", score.width},
                     {"height", score.height},
                     {"psnr_right_half", Finite(score.right_half_psnr)},
                     {"psnr_color_corrected", Finite(score.corrected_psnr)},
                     {"psnr_refined_cameras", Finite(score.refined_psnr)},
                     {"psnr_refined_cameras_color_corrected", Finite(score.refined_corrected_psnr)},
                     {"refined_shift_px", Finite(score.refined_shift_px)},
                     {"foreground_psnr", Finite(score.foreground_psnr)}});
    identical += score.mse == 0;
    if (!score.foreground_psnr) continue;
    foreground_sum += *score.foreground_psnr;
    ++foreground_count;
  }
  const double mean_mse = MeanOf(scores, [](const ViewScore& s) { return s.mse; });
  // Views that are scored only on the pixels that their mask selects.
  const auto masked_count = std::count_if(rendered.views.begin(), rendered.views.end(),
                                          [](const RenderedView& view) { return bool(view.seen); });
  // Without any mask this is 0 / 0, which Finite writes as null.
  const double mean_foreground = foreground_sum / double(foreground_count);
  return {
      {"schema", 1},
      {"psnr", Finite(MeanOf(scores, [](const ViewScore& s) { return s.psnr; }))},
      {"psnr_of_mean_mse", Finite(PsnrFromMse(mean_mse))},
      {"psnr_right_half", MeanOfKnown(scores, &ViewScore::right_half_psnr)},
      {"psnr_color_corrected", MeanOfKnown(scores, &ViewScore::corrected_psnr)},
      {"psnr_color_corrected_protocol", kCorrectedProtocol},
      {"psnr_refined_cameras", MeanOfKnown(scores, &ViewScore::refined_psnr)},
      {"psnr_refined_cameras_color_corrected",
       MeanOfKnown(scores, &ViewScore::refined_corrected_psnr)},
      {"psnr_refined_cameras_protocol", kRefinedProtocol},
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

// Size of the field's file among the optimiser's outputs.
json FieldBytes(const StageFacts& optimize) {
  uint64_t bytes = 0;
  for (const json& output : optimize.manifest.value("outputs", json::array())) {
    const fs::path path = TextOrEmpty(output, "path");
    if (path.parent_path().empty() && path.stem() == "field") {
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
  if (optimize) {
    seed = optimize->manifest.value("seed", json());
    // The seconds that are compared with others' are those of the optimisation.
    if (const std::string name = optimize->Device(); !name.empty()) device = name;
  }
  return {{"tets", optimize ? optimize->Count("tets") : json()},
          {"vertices", optimize ? optimize->Count("vertices") : json()},
          {"field_bytes", optimize ? FieldBytes(*optimize) : json()},
          {"seconds", std::move(seconds)},
          {"peak_rss_bytes", peak},
          {"device", std::move(device)},
          {"seed", std::move(seed)},
          {"git", run.stages.back().manifest.value("git", json())}};
}

// `watched`: the legend of the held-out curve.
std::vector<Plot> ConvergencePlots(const std::vector<TrainingRow>& rows,
                                   const std::string& watched) {
  PlotSeries train{"training batches", {}, {}, 5, false, false};
  PlotSeries held_out{watched, {}, {}, 1, false, true};
  PlotSeries loss{"loss (left)", {}, {}, 0, false, false},
      tets{"tets (right)", {}, {}, 2, true, false};
  for (const TrainingRow& row : rows) {
    const auto add = [&](PlotSeries& series, double y) {
      series.x.push_back(row.seconds);
      series.y.push_back(y);
    };
    // A row without batches leaves a gap in the curves.
    add(train, row.train_psnr.value_or(NAN));
    add(loss, row.loss.value_or(NAN));
    add(tets, double(row.tets));
    if (row.heldout_psnr) add(held_out, *row.heldout_psnr);
  }
  Plot psnr;
  psnr.title = "PSNR during optimisation";
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

// What the optimiser estimated of the training photos.
void ReadEstimates(const RunFacts& run, ReportContent& content) {
  const StageFacts* optimize = run.Find("optimize");
  if (!optimize) return;
  if (const fs::path file = optimize->folder / kMeshGrowthFile; fs::exists(file)) {
    content.growth = ReadMeshGrowth(file);
  }
  if (const fs::path file = optimize->folder / kPhotoExposuresFile; fs::exists(file)) {
    content.exposures = ReadPhotoExposures(file);
  }
  if (const fs::path file = optimize->folder / kCameraCorrectionsFile; fs::exists(file)) {
    content.cameras = ReadCameraCorrections(file);
  }
}

// How many items are so; null if there are none at all, because nothing was estimated.
template <class T, class Is>
json CountIf(const std::vector<T>& items, Is is) {
  return items.empty() ? json() : json(std::count_if(items.begin(), items.end(), is));
}

// The curves are optional: without gnuplot or metrics.csv the report is still written and states
// why they are missing.
void DrawConvergence(const RunFacts& run, Stage& stage, ReportContent& content) {
  const StageFacts* optimize = run.Find("optimize");
  try {
    if (!optimize) throw DataError("the optimiser's folder is missing");
    const auto rows = ReadTrainingLog(optimize->folder / kTrainingLogFile);
    const fs::path scratch = stage.Scratch("gnuplot");
    for (const Plot& plot : ConvergencePlots(rows, WatchedViewsInWords(*optimize))) {
      const fs::path svg = scratch / "curve.svg";
      DrawPlot(plot, svg, scratch);
      content.curves_svg.push_back(ReadText(svg));
    }
    if (const std::optional<Plot> plot = GrowthPlot({{"", content.growth}})) {
      DrawPlot(*plot, scratch / "growth.svg", scratch);
      content.growth_svg = ReadText(scratch / "growth.svg");
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const EnvironmentError& error) {
    // A missing program may be there when the same command runs again.
    content.no_curves_reason = error.what();
    content.warnings.push_back(fmt::format("no convergence curves: {}", error.what()));
    stage.Degrade(content.warnings.back());
  } catch (const Error& error) {
    content.no_curves_reason = error.what();
    Warn(content.warnings, fmt::format("no convergence curves: {}", error.what()));
  }
}

std::string DatasetOf(const RunFacts& run) {
  const StageFacts* scene = run.Scene();
  if (scene) {
    for (const json& input : scene->manifest.value("inputs", json::array())) {
      const fs::path path = TextOrEmpty(input, "path");
      // "demo/photos" identifies the data set, "photos" does not.
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

// The report attributes the photos and times of the views' run to the surface, which is wrong if
// the surface comes from another run.
void WarnOfAnotherField(ReportContent& content) {
  const StageFacts *views = content.run.Find("render"), *surface = content.run.Find("surface");
  const std::string of_views = views->HashOfInput("optimize");
  const std::string of_surface = surface->HashOfInput("optimize");
  if (of_views.empty() || of_surface.empty() || of_views == of_surface) return;
  Warn(content.warnings,
       "the surface was made from another field than the views; give those of one run, so that "
       "figures belong together");
}

}  // namespace

void EvaluateOptions::Check() const {
  if (!(threshold_percent > 0) || threshold_percent > 100) {
    throw UsageError(
        fmt::format("threshold is {}; expected more than 0 and at most 100 [% of the "
                    "diagonal]",
                    threshold_percent));
  }
  if (surface_samples < 1000 || surface_samples > 50'000'000) {
    throw UsageError(
        fmt::format("surface_samples is {}; expected 1,000 to 50,000,000", surface_samples));
  }
  const auto& b = ground_truth_bounds;
  if (!b.empty() && !(b.size() == 6 && b[0] < b[3] && b[1] < b[4] && b[2] < b[5])) {
    throw UsageError(
        "ground_truth_bounds must be XMIN YMIN ZMIN XMAX YMAX ZMAX, each minimum below its "
        "maximum");
  }
}

void Evaluate(const EvaluateOptions& options, Stage& stage) {
  ReportContent content;
  content.rendered = ReadRenderedViews(stage.Input("VIEWS") / kRenderedViewsFile);
  content.run = ReadRunFacts(stage.Input("VIEWS"));
  for (const std::string& warning : content.run.warnings) Warn(content.warnings, warning);
  content.dataset = DatasetOf(content.run);
  content.scene = SceneOf(content.run);
  const std::optional<Scene>& scene = content.scene;

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
             "{} views are identical to their ground truth: their PSNR is infinite, so no mean is "
             "given",
             metrics["identical_views"].get<size_t>()));
  }

  if (stage.HasInput("SURFACE")) {
    const Timer timer;
    AddStage(stage.Input("SURFACE"), content.run);
    WarnOfAnotherField(content);
    content.surface = EvaluateSurface(options, scene, content.rendered, content.run.stages.back(),
                                      stage, content.warnings);
    stage.Seconds("surface", timer.seconds());
  }
  content.depth = EvaluateDepth(content.rendered, scene, content.surface, stage, content.warnings);
  content.normals = EvaluateNormals(content.rendered, scene, stage, content.warnings);
  for (const std::string& warning : QualityWarnings(content.scores, scene)) {
    Warn(content.warnings, warning);
  }
  metrics.update(RunMetrics(content.run));
  metrics["surface"] = content.surface ? SurfaceJson(*content.surface, options) : json();
  metrics["depth"] = content.depth ? DepthJson(*content.depth) : json();
  metrics["normals"] = content.normals ? NormalsJson(*content.normals) : json();
  ReadEstimates(content.run, content);
  DrawConvergence(content.run, stage, content);
  metrics["uneven_photos"] = CountIf(content.exposures, IsUneven);
  metrics["moved_cameras"] = CountIf(content.cameras, MovedMuch);

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
