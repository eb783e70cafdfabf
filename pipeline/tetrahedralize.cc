// tetrec-tetrahedralize: the first tetrahedral mesh of a scene and the field that optimisation
// starts from.
#include "core/error.h"
#include "core/log.h"
#include "core/option_checks.h"
#include "core/progress.h"
#include "core/stage.h"
#include "field/initial_field.h"
#include "mesh/delaunay.h"
#include "mesh/start_points.h"
#include "mesh/tetgen.h"
#include "scene/carve.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrec {
namespace {

struct TetrahedralizeOptions {
  std::string start = "auto";
  uint64_t seed = 1;
  int resolution = 0;
  PointFilter filter;
  PointStartOptions shell;
  CarveStartOptions carve;
  InitialFieldOptions field;
};

void AddOptions(CLI::App& app, TetrahedralizeOptions& options) {
  app.add_option(
         "--start", options.start,
         "where the first vertices come from: points (sparse points, a fill and a far "
         "shell), carve (alpha masks), grid (the subject's bounds), tetgen (the bounds, "
         "meshed by TetGen); auto: points if the scene has any, else carve if it has alpha, "
         "else grid")
      ->check(CLI::IsMember({"auto", "points", "carve", "grid", "tetgen"}));
  app.add_option("--seed", options.seed, "seed of jitter and random vertices");
  app.add_option("--resolution", options.resolution,
                 "carve, grid, tetgen: cells along the longest side; 0: 64, 32, 24")
      ->check(CLI::Range(0, 512));
  app.add_option("--max-reprojection-error", options.filter.max_reprojection_error_px,
                 "points: drop sparse points seen worse than this [px]")
      ->check(tetrec::AboveZero());
  app.add_option("--min-track-length", options.filter.min_track_length,
                 "points: drop sparse points seen by fewer views")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--min-spacing", options.filter.min_spacing,
                 "points: of closer points keep one [world units; the subject's longest side is 2]")
      ->check(tetrec::AtLeastZero());
  app.add_option("--sphere-points", options.shell.sphere_points,
                 "points: vertices on each sphere of the fill; the far shell has twice as many")
      ->check(CLI::Range(20, 100000));
  app.add_option("--far-share", options.shell.far_share,
                 "points: share of the sparse points that the far shell encloses")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--outer-points", options.carve.outer_points,
                 "carve: random vertices in the free space of the box")
      ->check(CLI::Range(0, 1000000));
  app.add_option("--start-density", options.field.density,
                 "carve, grid, tetgen: first density of the subject [1 / world unit]")
      ->check(tetrec::AboveZero());
}

std::string ChooseStart(const std::string& wanted, const Scene& scene) {
  if (wanted == "points" && scene.points.empty()) {
    throw UsageError("--start points: the scene has no sparse points; use --start carve or grid");
  }
  if (wanted == "carve" && !scene.has_alpha) {
    throw UsageError(
        "--start carve: the scene's pictures have no alpha; use --start points or grid");
  }
  if (wanted != "auto") return wanted;
  return !scene.points.empty() ? "points" : scene.has_alpha ? "carve" : "grid";
}

// The subject's box with some room, so that its surface is not cut.
Bounds3 BoxOf(const Scene& scene) { return scene.subject_bounds.Scaled(1.1); }

RadianceField FieldOfSubject(const StartPoints& start, const InitialFieldOptions& options) {
  DelaunayResult delaunay = BuildDelaunay(start.positions);
  std::vector<VertexKind> kinds;
  for (const uint32_t p : delaunay.point_of_vertex) kinds.push_back(start.kinds[p]);
  return MakeSubjectField(std::move(delaunay.mesh), kinds, options);
}

RadianceField StartCarved(const Scene& scene, const TetrahedralizeOptions& options, Stage& stage) {
  const std::vector<AlphaMask> masks = ReadTrainingMasks(stage.Input("scene"), scene);
  const Bounds3 bounds = scene.subject_bounds.Scaled(1.05);
  const int cells = options.resolution > 0 ? options.resolution : 64;
  const OccupancyGrid grid = CarveMasks(masks, bounds, CubicCells(bounds, cells));
  LogInfo("carved {}x{}x{} cells by {} masks: {} inside", grid.size.x, grid.size.y, grid.size.z,
          masks.size(), WithThousands(grid.InsideCount()));
  stage.Count("carved_cells", grid.InsideCount());
  return FieldOfSubject(StartFromCarve(grid, options.carve, options.seed), options.field);
}

RadianceField StartGrid(const Scene& scene, const TetrahedralizeOptions& options) {
  const int cells = options.resolution > 0 ? options.resolution : 32;
  return FieldOfSubject(StartFromGrid(BoxOf(scene), cells, options.seed), options.field);
}

RadianceField StartTetgen(const Scene& scene, const TetrahedralizeOptions& options, Stage& stage) {
  const Bounds3 box = BoxOf(scene);
  const glm::dvec3 size = box.Size();
  const double edge =
      std::max({size.x, size.y, size.z}) / (options.resolution > 0 ? options.resolution : 24);
  // Volume of a regular tet.
  TetMesh mesh = TetrahedralizeBox(box, edge * edge * edge / (6 * std::sqrt(2.0)), options.seed,
                                   stage.Scratch("tetgen"));
  const std::vector<VertexKind> kinds(mesh.positions.size(), VertexKind::kInner);
  return MakeSubjectField(std::move(mesh), kinds, options.field);
}

RadianceField StartPhotos(const Scene& scene, const TetrahedralizeOptions& options, Stage& stage) {
  std::vector<SparsePoint> sparse;
  for (const ScenePoint& p : scene.points) {
    sparse.push_back({p.position, p.reprojection_error_px, p.track_length});
  }
  const FilteredPoints filtered = FilterPoints(sparse, options.filter);
  std::vector<glm::dvec3> positions, cameras_in_world;
  for (const uint32_t i : filtered.kept) positions.push_back(sparse[i].position);
  for (const View& view : scene.views) {
    cameras_in_world.push_back(view.cam_from_world.Inverse().translation);
  }
  const PointStart start = StartFromPoints(positions, cameras_in_world, scene.subject_bounds,
                                           options.shell, options.seed);
  LogInfo(
      "points: {} of {} used; dropped: {} not finite, {} by reprojection error, {} by track "
      "length, "
      "{} too close to another, {} beyond the far shell of radius {:.3g}; {} vertices of fill",
      WithThousands(positions.size() - start.dropped_far), WithThousands(sparse.size()),
      filtered.not_finite, filtered.high_error, filtered.short_track, filtered.too_close,
      start.dropped_far, start.far_radius, WithThousands(start.fill));
  if (positions.size() - start.dropped_far < 100) {
    LogWarning(
        "only {} sparse points are left: loosen --max-reprojection-error or --min-track-length",
        positions.size() - start.dropped_far);
  }
  stage.Count("points", {{"read", sparse.size()},
                         {"used", positions.size() - start.dropped_far},
                         {"not_finite", filtered.not_finite},
                         {"high_reprojection_error", filtered.high_error},
                         {"short_track", filtered.short_track},
                         {"too_close", filtered.too_close},
                         {"beyond_far_shell", start.dropped_far}});
  stage.Count("fill_vertices", start.fill);
  stage.Note("far_radius", start.far_radius);

  DelaunayResult delaunay = BuildDelaunay(start.points.positions);
  std::vector<VertexKind> kinds;
  std::vector<std::optional<glm::vec3>> colors_srgb;
  for (const uint32_t p : delaunay.point_of_vertex) {
    kinds.push_back(start.points.kinds[p]);
    colors_srgb.emplace_back();
    if (start.points.point[p] == kNoPoint) continue;
    const auto& rgb = scene.points[filtered.kept[start.points.point[p]]].color_srgb;
    colors_srgb.back() = glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f;
  }
  return MakePhotoField(std::move(delaunay.mesh), kinds, colors_srgb, options.field);
}

RadianceField MakeStart(const std::string& start, const Scene& scene,
                        const TetrahedralizeOptions& options, Stage& stage) {
  if (start == "points") return StartPhotos(scene, options, stage);
  if (start == "carve") return StartCarved(scene, options, stage);
  if (start == "grid") return StartGrid(scene, options);
  return StartTetgen(scene, options, stage);
}

void Report(const TetMesh& mesh, Stage& stage) {
  const TetMeshQuality quality = MeasureQuality(mesh);
  TETREC_CHECK(quality.boundary_faces == 12,
               fmt::format("the hull has {} triangles, a box has 12", quality.boundary_faces));
  LogInfo(
      "mesh: {} vertices, {} tets; radius ratio {:.2g} min, {:.3f} mean; volume {:.3g} min, "
      "{:.3g} mean, {:.6g} in all",
      WithThousands(mesh.positions.size()), WithThousands(mesh.tets.size()),
      quality.min_radius_ratio, quality.mean_radius_ratio, quality.min_volume, quality.mean_volume,
      quality.total_volume);
  stage.Count("vertices", mesh.positions.size());
  stage.Count("tets", mesh.tets.size());
  stage.Count("quality", {{"min_radius_ratio", quality.min_radius_ratio},
                          {"mean_radius_ratio", quality.mean_radius_ratio},
                          {"min_volume", quality.min_volume},
                          {"mean_volume", quality.mean_volume},
                          {"total_volume", quality.total_volume},
                          {"boundary_faces", quality.boundary_faces}});
}

void RunTetrahedralize(const TetrahedralizeOptions& options, Stage& stage) {
  const Scene scene = ReadScene(stage.Input("scene"));
  const std::string start = ChooseStart(options.start, scene);
  LogInfo("start: {}", start);
  stage.Note("start", start);
  const Timer timer;
  const RadianceField field = MakeStart(start, scene, options, stage);
  CheckTetMesh(field.mesh);
  CheckConvexDomain(field.mesh);
  CheckField(field);
  stage.Seconds("mesh", timer.seconds());
  Report(field.mesh, stage);
  WriteTetMesh(stage.Output("mesh.tet"), field.mesh);
  WriteField(stage.Output("field.tetf"), field);
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  tetrec::StageCommand command("tetrahedralize", 1,
                               "Fills a scene with tetrahedra: writes mesh.tet and field.tetf, the "
                               "mesh with the first density "
                               "and colour of each vertex.");
  tetrec::TetrahedralizeOptions options;
  command.InputStage("scene", "folder that tetrec-sfm or tetrec-import wrote", {"sfm", "import"});
  tetrec::AddOptions(command.app(), options);
  return command.Run(argc, argv,
                     [&](tetrec::Stage& stage) { tetrec::RunTetrahedralize(options, stage); });
}
