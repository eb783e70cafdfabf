// The surface's part of the evaluation.
#include "eval/evaluate_surface.h"

#include "core/checked_json.h"
#include "core/error.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "eval/mesh_preview.h"
#include "eval/metrics_json.h"
#include "geometry/checked_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

bool HasOutput(const StageFacts& surface, const std::string& file) {
  for (const json& output : surface.manifest.value("outputs", json::array())) {
    if (TextOrEmpty(output, "path") == file) return true;
  }
  return false;
}

// The texture that tetrec-surface baked; empty if there is none.
Image TextureOf(const StageFacts& surface, const TriangleMesh& mesh) {
  const std::string file = "surface.png";
  if (mesh.corner_coordinates.empty() || !HasOutput(surface, file)) return {};
  const Image texture = ReadImage(surface.folder / file);
  return texture.channels == 3 ? texture : CompositeOver(texture, 0, 0, 0);
}

// The only PLY file among the stage's outputs, or surface.ply.
std::string SurfaceFile(const StageFacts& surface) {
  std::vector<std::string> files;
  for (const json& output : surface.manifest.value("outputs", json::array())) {
    const std::string path = TextOrEmpty(output, "path");
    if (fs::path(path).extension() == ".ply") files.push_back(path);
  }
  if (files.size() == 1) return files[0];
  if (std::count(files.begin(), files.end(), "surface.ply") == 1) return "surface.ply";
  throw DataError(
      fmt::format("{}: has {} PLY files and none is surface.ply; run tetrec-surface again",
                  surface.folder.string(), files.size()));
}

// The way from the file's coordinates to the input's. Surfaces of versions before 3 were in the
// input's coordinates.
Similarity3 InputFromSurface(const StageFacts& surface) {
  const CheckedJson manifest(surface.manifest, surface.folder / "manifest.json");
  if (!manifest.Has("notes") || !manifest.Field("notes").Has("input_from_surface")) return {};
  constexpr double kRotationTolerance = 1e-5;  // as of the scene and the world that it comes from
  return ReadSimilarity(manifest.Field("notes").Field("input_from_surface"), kRotationTolerance);
}

void DrawPreviews(const TriangleMesh& mesh, const Scene& scene, SurfaceResult& result) {
  PreviewOptions options;
  for (const glm::vec3& position : mesh.positions) options.bounds.Add(glm::dvec3(position));
  // More than the margin that tetrec-surface leaves around the subject; without its bounds a
  // surface reaches out to the scene's end.
  const Bounds3 subject = scene.subject_bounds.Scaled(1.6);
  const Bounds3 common{glm::max(options.bounds.min, subject.min),
                       glm::min(options.bounds.max, subject.max)};
  if (!common.IsEmpty()) options.bounds = common;
  if (options.bounds.IsEmpty()) return;  // a mesh without vertices
  options.bounds = options.bounds.Scaled(1.0001);
  if (mesh.colors_srgb.size() == mesh.positions.size()) {
    result.color_pictures = RenderTurntable(mesh, options);
  }
  options.use_colors = false;
  result.clay_pictures = RenderTurntable(mesh, options);
}

void ScorePictures(const TriangleMesh& mesh_in_world, const Image& texture, const Scene& scene,
                   const RenderedViews& rendered, SurfaceResult& result) {
  result.pictures = ScoreSurfacePictures(mesh_in_world, texture, scene, rendered);
  if (!result.pictures || result.pictures->views.empty()) return;
  const json means = SurfacePicturesJson(*result.pictures);
  LogInfo(
      "pictures of the {} surface: PSNR {:.2f} dB; {:.2f} dB in vertex colours, {:.2f} dB of the "
      "field over the same pixels, {:.0f} % of all",
      result.pictures->textured ? "textured" : "coloured", means["psnr"].get<double>(),
      means["vertex_color_psnr"].get<double>(), means["field_psnr"].get<double>(),
      100 * means["covered"].get<double>());
}

void CompareWithTruth(const TriangleMesh& surface, const Similarity3& input_from_surface,
                      const std::optional<Scene>& scene, const EvaluateOptions& options,
                      const Stage& stage, SurfaceResult& result,
                      std::vector<std::string>& warnings) {
  Similarity3 truth_from_surface = input_from_surface;
  if (stage.HasInput("cameras")) {
    if (!scene)
      throw DataError("the true cameras require the scene folder of the run, which is missing");
    result.alignment = AlignByCameras(*scene, ReadTrueCameras(stage.Input("cameras")));
    const Alignment& alignment = *result.alignment;
    LogInfo(
        "alignment: {} cameras, centres off by {:.4g} RMS ({:.3f} % of their spread), directions "
        "by "
        "{:.3f} degrees on average",
        alignment.matched, alignment.center_rms,
        100 * alignment.center_rms / alignment.center_spread, alignment.rotation_mean_deg);
    if (!alignment.unmatched.empty()) {
      Warn(warnings, fmt::format("{} of {} views have no true camera and are left out of the "
                                 "alignment, the first is '{}'",
                                 alignment.unmatched.size(), scene->views.size(),
                                 alignment.unmatched.front()));
    }
    if (alignment.rotation_mean_deg > 2) {
      Warn(warnings,
           fmt::format("after the alignment, the cameras' directions differ from the true ones by "
                       "{:.1f} degrees on average: do not trust the surface's scores",
                       alignment.rotation_mean_deg));
    }
    truth_from_surface = alignment.truth_from_input * input_from_surface;
  }
  SurfaceScoreOptions score_options;
  score_options.threshold = options.threshold_percent / 100;
  score_options.samples = options.surface_samples;
  score_options.seed = options.seed;
  if (const auto& b = options.ground_truth_bounds; !b.empty()) {
    score_options.bounds = Bounds3{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
  }
  const TriangleMesh truth = ReadTriangleMesh(stage.Input("ground-truth"));
  result.scores = CompareSurfaces(Transformed(surface, truth_from_surface), truth, score_options);
  const SurfaceScores& scores = *result.scores;
  if (scores.reconstruction_samples == 0) {
    const glm::dvec3 &low = scores.crop.min, &high = scores.crop.max;
    Warn(warnings,
         fmt::format("no part of the surface is inside the scored box, from {:.4g},{:.4g},{:.4g} "
                     "to {:.4g},{:.4g},{:.4g} in the true mesh's coordinates, so that its F-score "
                     "is 0; check --cameras and --ground-truth-bounds",
                     low.x, low.y, low.z, high.x, high.y, high.z));
  }
  LogInfo(
      "surface: F-score {:.4f} (precision {:.4f}, recall {:.4f}) at {:.4g}, diagonal {:.4g}; "
      "normals "
      "off by {} degrees on average",
      scores.f_score, scores.precision, scores.recall, scores.threshold, scores.diagonal,
      scores.normal_angle_deg ? fmt::format("{:.1f}", *scores.normal_angle_deg) : "?");
}

json AlignmentJson(const Alignment& a) {
  return {{"scale", a.truth_from_input.scale},
          {"rotation", ToJson(a.truth_from_input.rotation)},
          {"translation", ToJson(a.truth_from_input.translation)},
          {"matched_views", a.matched},
          {"unmatched_views", a.unmatched},
          {"center_rms", a.center_rms},
          {"center_max", a.center_max},
          {"center_spread", a.center_spread},
          {"rotation_mean_deg", a.rotation_mean_deg},
          {"rotation_max_deg", a.rotation_max_deg}};
}

json AtDistancesJson(const SurfaceScores& s) {
  json rows = json::array();
  for (const ScoresAtDistance& at : s.at_distances) {
    rows.push_back({{"threshold", at.threshold},
                    {"threshold_percent_of_diagonal", 100 * at.threshold / s.diagonal},
                    {"f_score", at.f_score},
                    {"precision", at.precision},
                    {"recall", at.recall}});
  }
  return rows;
}

json ScoresJson(const SurfaceScores& s, const EvaluateOptions& options) {
  return {{"f_score", s.f_score},
          {"precision", s.precision},
          {"recall", s.recall},
          {"accuracy", Finite(s.accuracy)},
          {"completeness", Finite(s.completeness)},
          {"chamfer", Finite(s.chamfer)},
          {"threshold", s.threshold},
          {"threshold_percent_of_diagonal", options.threshold_percent},
          {"at_thresholds", AtDistancesJson(s)},
          {"normal_angle_deg", Finite(s.normal_angle_deg)},
          {"diagonal", s.diagonal},
          {"bounds_min", ToJson(s.crop.min)},
          {"bounds_max", ToJson(s.crop.max)},
          {"bounds_from", options.ground_truth_bounds.empty()
                              ? "the truth's bounding box grown by 5 %, along thin "
                                "sides by 5 % of a cube of its diagonal"
                              : "--ground-truth-bounds"},
          {"reconstruction_samples", s.reconstruction_samples},
          {"ground_truth_samples", s.truth_samples}};
}

}  // namespace

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
                 {"pictures", nullptr},
                 {"ground_truth", nullptr},
                 {"alignment", nullptr}};
  if (surface.scores) result["ground_truth"] = ScoresJson(*surface.scores, options);
  if (surface.pictures) result["pictures"] = SurfacePicturesJson(*surface.pictures);
  if (surface.alignment) result["alignment"] = AlignmentJson(*surface.alignment);
  return result;
}

SurfaceResult EvaluateSurface(const EvaluateOptions& options, const std::optional<Scene>& scene,
                              const RenderedViews& rendered, const StageFacts& surface_stage,
                              Stage& stage, std::vector<std::string>& warnings) {
  SurfaceResult result;
  result.file = SurfaceFile(surface_stage);
  const TriangleMesh mesh = ReadTriangleMesh(surface_stage.folder / result.file);
  result.facts = MeasureMesh(mesh);
  LogInfo("surface: {} triangles, {} components, {}", WithThousands(result.facts.faces),
          WithThousands(result.facts.components),
          result.facts.watertight ? "watertight" : "not watertight");
  if (mesh.triangles.empty()) Warn(warnings, "the surface has no triangle");
  // Ways are composed in double: the input's coordinates may be too large for float.
  const Similarity3 input_from_surface = InputFromSurface(surface_stage);
  if (scene) {
    const TriangleMesh in_world =
        Transformed(mesh, scene->input_from_world.Inverse() * input_from_surface);
    DrawPreviews(in_world, *scene, result);
    ScorePictures(in_world, TextureOf(surface_stage, mesh), *scene, rendered, result);
  }
  result.model =
      MakeSurfaceModel(surface_stage, mesh, input_from_surface, stage.Scratch("surface"));
  if (stage.HasInput("ground-truth")) {
    CompareWithTruth(mesh, input_from_surface, scene, options, stage, result, warnings);
  }
  return result;
}

}  // namespace tetrec
