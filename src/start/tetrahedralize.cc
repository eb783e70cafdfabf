// From a scene to its first mesh and field.
#include "start/tetrahedralize.h"

#include "core/error.h"
#include "core/log.h"
#include "core/option_range.h"
#include "core/progress.h"
#include "core/timer.h"
#include "mesh/delaunay.h"
#include "scene/carve.h"
#include "scene/scene.h"
#include "start/tetgen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace tetrec {
namespace {

// For opaque photos.
StartKind StartWithoutDepth(const Scene& scene) {
  return scene.points.empty() ? StartKind::kGrid : StartKind::kPoints;
}

StartKind ChooseStart(std::optional<StartKind> wanted, const Scene& scene) {
  if (wanted == StartKind::kPoints && scene.points.empty()) {
    throw UsageError("start points: the scene has no sparse points; choose carve or grid");
  }
  if (wanted == StartKind::kCarve && !scene.has_alpha) {
    throw UsageError("start carve: the scene's images have no alpha; choose points or grid");
  }
  if (wanted) return *wanted;
  if (scene.has_alpha) return scene.points.empty() ? StartKind::kCarve : StartKind::kPoints;
  return scene.ViewsOf(Split::kTrain).size() > 1 ? StartKind::kDense : StartWithoutDepth(scene);
}

int ResolutionOr(const TetrahedralizeOptions& options, int otherwise) {
  return options.resolution > 0 ? options.resolution : otherwise;
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
  const int cells = ResolutionOr(options, 64);
  const OccupancyGrid grid = CarveMasks(masks, bounds, CubicCells(bounds, cells));
  LogInfo("carved {}x{}x{} cells by {} masks: {} inside", grid.size.x, grid.size.y, grid.size.z,
          masks.size(), WithThousands(grid.InsideCount()));
  stage.Count("carved_cells", grid.InsideCount());
  return FieldOfSubject(StartFromCarve(grid, options.carve, options.seed), options.field);
}

RadianceField StartGrid(const Scene& scene, const TetrahedralizeOptions& options) {
  const int cells = ResolutionOr(options, 32);
  return FieldOfSubject(StartFromGrid(BoxOf(scene), cells, options.seed), options.field);
}

RadianceField StartTetgen(const Scene& scene, const TetrahedralizeOptions& options, Stage& stage) {
  const Bounds3 box = BoxOf(scene);
  const glm::dvec3 size = box.Size();
  const double edge = std::max({size.x, size.y, size.z}) / ResolutionOr(options, 24);
  // The bound is the volume of a regular tet.
  TetMesh mesh = TetrahedralizeBox(box, edge * edge * edge / (6 * std::sqrt(2.0)), options.seed,
                                   stage.Scratch("tetgen"));
  const std::vector<VertexKind> kinds(mesh.positions.size(), VertexKind::kInner);
  return MakeSubjectField(std::move(mesh), kinds, options.field);
}

std::vector<SparsePoint> SparsePointsOf(const Scene& scene) {
  std::vector<SparsePoint> sparse;
  for (const ScenePoint& p : scene.points) {
    sparse.push_back({p.position, p.reprojection_error_px, p.track_length});
  }
  return sparse;
}

std::string DropsOf(const FilteredPoints& filtered) {
  return fmt::format(
      "dropped: {} not finite, {} by reprojection error, {} by track length, {} too close to "
      "another",
      filtered.not_finite, filtered.high_error, filtered.short_track, filtered.too_close);
}

nlohmann::json CountsOf(const FilteredPoints& filtered, size_t read, size_t used) {
  return {{"read", read},
          {"used", used},
          {"not_finite", filtered.not_finite},
          {"high_reprojection_error", filtered.high_error},
          {"short_track", filtered.short_track},
          {"too_close", filtered.too_close}};
}

void ReportPoints(const FilteredPoints& filtered, size_t read, const PointStart& start,
                  Stage& stage) {
  const size_t used = filtered.kept.size() - start.dropped_far;
  LogInfo(
      "points: {} of {} used; {}, {} beyond the far shell of radius {:.3g}; {} vertices of fill",
      WithThousands(used), WithThousands(read), DropsOf(filtered), start.dropped_far,
      start.far_radius, WithThousands(start.fill));
  if (used < 100) {
    LogWarning(
        "only {} sparse points are left: loosen the bounds on reprojection error or track length",
        used);
  }
  nlohmann::json counts = CountsOf(filtered, read, used);
  counts["beyond_far_shell"] = start.dropped_far;
  stage.Count("points", counts);
  stage.Count("fill_vertices", start.fill);
  stage.Note("far_radius", start.far_radius);
}

RadianceField StartPhotos(const Scene& scene, const TetrahedralizeOptions& options, Stage& stage) {
  const std::vector<SparsePoint> sparse = SparsePointsOf(scene);
  const FilteredPoints filtered = FilterPoints(sparse, options.filter);
  std::vector<glm::dvec3> positions, cameras_in_world;
  for (const uint32_t i : filtered.kept) positions.push_back(sparse[i].position);
  for (const View& view : scene.views) {
    cameras_in_world.push_back(view.cam_from_world.Inverse().translation);
  }
  const PointStart start = StartFromPoints(positions, cameras_in_world, scene.subject_bounds,
                                           options.shell, options.seed);
  ReportPoints(filtered, sparse.size(), start, stage);

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

void ReportStereo(const StereoResult& stereo, Stage& stage) {
  const double share = 100.0 / double(std::max<uint64_t>(stereo.pixels, 1));
  LogInfo(
      "depth maps: {:.0f} % of the pixels matched, {:.0f} % confirmed by other views; {} of {} "
      "views without depth; {} points every {:.1f} pixels, {} dropped as contradicted",
      share * double(stereo.matched), share * double(stereo.confirmed), stereo.views_without,
      stereo.maps.size(), WithThousands(stereo.fusion.points.size()), stereo.fusion.spacing_px,
      WithThousands(stereo.fusion.contradicted));
  stage.Count("depth", {{"pixels", stereo.pixels},
                        {"matched", stereo.matched},
                        {"confirmed", stereo.confirmed},
                        {"views_without", stereo.views_without},
                        {"slanted", stereo.is_slanted},
                        {"points", stereo.fusion.points.size()},
                        {"contradicted_points", stereo.fusion.contradicted},
                        {"spacing_px", stereo.fusion.spacing_px}});
}

// `filtered`: the sparse points that were read.
void ReportDense(const DenseStart& start, const FilteredPoints& filtered, size_t read,
                 Stage& stage) {
  LogInfo("sparse points: {} of {} used; {}", WithThousands(filtered.kept.size()),
          WithThousands(read), DropsOf(filtered));
  stage.Count("points", CountsOf(filtered, read, filtered.kept.size()));
  LogInfo(
      "start: {} points, {} before and {} behind them, {} vertices of fill, {} beyond the far "
      "shell of radius {:.3g}; {} sight lines ({} lost); {} tets full, {} free; {} points in "
      "free space",
      WithThousands(start.surface), WithThousands(start.front), WithThousands(start.behind),
      WithThousands(start.fill), WithThousands(start.dropped_far), start.far_radius,
      WithThousands(start.sight_lines), start.lost_lines, WithThousands(start.full_tets),
      WithThousands(start.free_tets), WithThousands(start.free_points));
  stage.Count("dense", {{"surface", start.surface},
                        {"front", start.front},
                        {"behind", start.behind},
                        {"beyond_far_shell", start.dropped_far},
                        {"sight_lines", start.sight_lines},
                        {"lost_sight_lines", start.lost_lines},
                        {"full_tets", start.full_tets},
                        {"free_tets", start.free_tets},
                        {"points_in_free_space", start.free_points}});
  stage.Count("fill_vertices", start.fill);
  stage.Note("far_radius", start.far_radius);
}

StereoResult FindAndWriteDepths(const Scene& scene, const std::vector<StereoView>& views,
                                const StereoOptions& options, Stage& stage) {
  const Timer timer;
  StereoResult stereo = FindDepths(scene, views, options);
  stage.Seconds("depth", timer.seconds());
  ReportStereo(stereo, stage);
  const std::filesystem::path folder = stage.Output("depth");
  std::filesystem::create_directories(folder);
  for (const StereoDepth& map : stereo.maps)
    WriteStereoDepth(folder / StereoDepthName(map.view), map);
  WriteDensePoints(folder / "points.ply", stereo.fusion.points);
  return stereo;
}

// One point per kPixelsPerDensePoint of the photos, so that what is between the points is still
// learned. Where masks leave little, no more than one per kSeenPixelsPerDensePoint of what they
// leave: a point becomes two to three vertices, and photos can tell apart one in 16 pixels.
size_t DensePointsFor(const Scene& scene, std::span<const StereoView> views) {
  constexpr double kPixelsPerDensePoint = 100, kSeenPixelsPerDensePoint = 40;
  constexpr double kFewest = 2'000, kMost = 40'000;
  double pixels = 0, seen = 0;
  for (const StereoView& view : views) {
    const Camera& camera = scene.cameras[size_t(scene.views[view.view].camera)];
    const double of_view = camera.width * double(camera.height);
    const auto left_out = double(std::ranges::count(view.kinds, PixelKind::kOther));
    pixels += of_view;
    seen += of_view * (1 - left_out / double(view.kinds.size()));
  }
  const double points = std::min(pixels / kPixelsPerDensePoint, seen / kSeenPixelsPerDensePoint);
  return size_t(std::clamp(points, kFewest, kMost));
}

// None if the photos agree on too few depths and another start may take its place.
std::optional<RadianceField> StartDense(const Scene& scene, const TetrahedralizeOptions& options,
                                        Stage& stage) {
  const std::vector<StereoView> views =
      ReadStereoViews(stage.Input("scene"), scene, options.stereo.max_size);
  StereoOptions stereo_options = options.stereo;
  if (stereo_options.fusion.max_points == 0) {
    stereo_options.fusion.max_points = DensePointsFor(scene, views);
  }
  const StereoResult stereo = FindAndWriteDepths(scene, views, stereo_options, stage);
  constexpr size_t kLeastPoints = 200;
  const size_t found = stereo.fusion.points.size();
  if (!options.start && found < kLeastPoints) return std::nullopt;
  if (found == 0) {
    throw DataError(
        "no two photos show the same surface at depths that agree, so a dense start is impossible; "
        "choose --start points, carve or grid");
  }
  const std::vector<SparsePoint> sparse = SparsePointsOf(scene);
  std::vector<ScenePoint> kept;
  const FilteredPoints filtered = FilterPoints(sparse, options.filter);
  for (const uint32_t i : filtered.kept) kept.push_back(scene.points[i]);
  std::vector<glm::dvec3> centers, all_cameras;
  for (const StereoView& view : views) {
    centers.push_back(view.cam_from_world.Inverse().translation);
  }
  for (const View& view : scene.views) {
    all_cameras.push_back(view.cam_from_world.Inverse().translation);
  }
  DenseStart start =
      StartFromDense(stereo.fusion.points, kept, centers, all_cameras, scene.subject_bounds,
                     options.shell, options.dense, options.field, options.seed);
  ReportDense(start, filtered, sparse.size(), stage);
  return std::move(start.field);
}

RadianceField MakeStart(StartKind start, const Scene& scene, const TetrahedralizeOptions& options,
                        Stage& stage) {
  switch (start) {
    case StartKind::kDense: {
      std::optional<RadianceField> dense = StartDense(scene, options, stage);
      if (dense) return std::move(*dense);
      const StartKind other = StartWithoutDepth(scene);
      LogWarning("the photos agree on too few depths: starts from {} instead", Name(other));
      return MakeStart(other, scene, options, stage);
    }
    case StartKind::kPoints:
      return StartPhotos(scene, options, stage);
    case StartKind::kCarve:
      return StartCarved(scene, options, stage);
    case StartKind::kGrid:
      return StartGrid(scene, options);
    case StartKind::kTetgen:
      return StartTetgen(scene, options, stage);
  }
  TETREC_CHECK(false, "a start of unknown kind");
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

}  // namespace

void TetrahedralizeOptions::Check() const {
  CheckRange("resolution", resolution, 0, 512);
  CheckAboveZero("max_reprojection_error", filter.max_reprojection_error_px);
  CheckRange("min_track_length", filter.min_track_length, 1u, 1'000'000u);
  CheckAtLeast("min_spacing", filter.min_spacing, 0.0);
  CheckRange("sphere_points", shell.sphere_points, 20, 100'000);
  CheckRange("far_share", shell.far_share, 0.0, 1.0);
  CheckRange("outer_points", carve.outer_points, 0, 1'000'000);
  CheckAboveZero("start_density", field.density);
  CheckAboveZero("surface_depth", dense.surface_depth);
  CheckAboveZero("layer_spacing", dense.layer_spacing);
  CheckAboveZero("free_depth", dense.free_depth);
  stereo.Check();
}

void RunTetrahedralize(const TetrahedralizeOptions& options, Stage& stage) {
  const Scene scene = ReadScene(stage.Input("scene"));
  const StartKind start = ChooseStart(options.start, scene);
  LogInfo("start: {}", Name(start));
  stage.Note("start", Name(start));
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

}  // namespace tetrec
