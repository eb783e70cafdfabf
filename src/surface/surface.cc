// From a field to its surface.
#include "surface/surface.h"

#include "core/error.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/option_range.h"
#include "core/progress.h"
#include "core/timer.h"
#include "field/change_storage.h"
#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "mesh/mesh_facts.h"
#include "run/field_world.h"
#include "surface/align_with_photos.h"
#include "surface/crop.h"
#include "surface/export_cameras.h"
#include "surface/fill_holes.h"
#include "surface/level.h"
#include "surface/marching_tetrahedra.h"
#include "surface/occupancy.h"
#include "surface/opacity_level.h"
#include "surface/seen_depths.h"
#include "surface/simplify.h"
#include "surface/smooth.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrec {
namespace {

// Rays lose half of their light inside a wall. The wall begins where density has risen to this
// share of its value there; free space has far less.
constexpr double kWallBegins = 0.02;

// Gaps in what the cameras see are smaller than this share of the diagonal of the subject's bounds:
// on the demo 4 %, beside a mug.
constexpr double kLargestGap = 0.08;

// Ripples of a surface that was made from photos are lower than this share of the diagonal of the
// subject's bounds; what is higher is taken for shape.
constexpr double kMaxSmoothingMove = 0.003;

// Marching tetrahedra leave triangles far smaller than a pixel, which alignment would crumple. With
// this deviation, as a share of the diagonal of the subject's bounds, most of them are simplified
// away, and enough vertices are left for colours.
constexpr double kDeviationBeforeAlignment = 0.0002;
// Rounds of SmoothByNormals after alignment. Noise in the photos leaves small ripples; more than
// one round would also undo what alignment has found.
constexpr int kRoundsAfterAlignment = 1;

// The last rounds of alignment use the colours of the texture.
constexpr int kMostMovesByTexture = 4;
int MovesByTexture(const SurfaceOptions& options) {
  return options.texture.wanted ? std::min(options.align_rounds / 2, kMostMovesByTexture) : 0;
}

float ChooseIsovalue(const RadianceField& field, const FieldWorld& world,
                     const SurfaceOptions& options, Stage& stage) {
  if (options.isovalue > 0) return float(options.isovalue);
  if (world.cameras_in_world.empty()) {
    LogInfo("isovalue: world.json has no camera centres, rays come from all around the subject");
  }
  const HalfTransmittanceLevel level = FindHalfTransmittanceLevel(
      field, world.subject_bounds, world.cameras_in_world, options.rays, options.seed);
  const double isovalue = kWallBegins * level.isovalue;
  LogInfo(
      "isovalue: {:.4g} per world unit, {} of the density where {} of {} rays have lost half of "
      "their light ({} lost)",
      isovalue, kWallBegins, WithThousands(level.opaque_rays), WithThousands(level.rays),
      level.lost_rays);
  stage.Count("isovalue_rays",
              {{"cast", level.rays}, {"opaque", level.opaque_rays}, {"lost", level.lost_rays}});
  return float(isovalue);
}

LevelSet DensitySet(const RadianceField& stored, const FieldWorld& world,
                    const SurfaceOptions& options, Stage& stage) {
  // The level function is linear in each tet: densities of cells become means at their vertices.
  const RadianceField field = WithStorage(stored, FieldStorage::kVertex);
  const float isovalue = ChooseIsovalue(field, world, options, stage);
  stage.Note("isovalue", isovalue);
  return MarchTetrahedra(field.mesh,
                         SmoothedOccupancy(field.mesh, field.density, isovalue, options.smoothing),
                         kSurfaceOccupancy);
}

void ReportConfirmedDepths(const SeenDepths& seen, Stage& stage) {
  stage.Count("confirmed_depths", seen.confirmed_rays);
  if (seen.confirmed_rays == 0) return;
  LogInfo("{:.0f} % of these rays lose their light where depth maps of the photos show a surface",
          100 * double(seen.confirmed_rays) / double(seen.rays));
}

void ReportPassingRays(const SeenDepths& seen, Stage& stage) {
  const PassingRays& passing = seen.passing_rays;
  stage.Count("passing_rays", {{"stopped", passing.stopped}, {"open", passing.open}});
  if (passing.stopped + passing.open == 0) return;
  LogInfo(
      "{:.2g} % of these rays pass through a wall, and are stopped there; {:.2g} % leave the bounds"
      " of the surface after some loss, and count only before it",
      100 * double(passing.stopped) / double(seen.rays),
      100 * double(passing.open) / double(seen.rays));
}

// Nothing where the level is chosen automatically and there are no cameras to see it.
std::optional<LevelSet> OpacitySet(const RadianceField& stored, const FieldWorld& world,
                                   const Bounds3& bounds, const SurfaceOptions& options,
                                   Stage& stage) {
  if (options.level == SurfaceLevel::kDensity) return std::nullopt;
  if (options.level == SurfaceLevel::kAuto && options.isovalue > 0) return std::nullopt;
  const std::filesystem::path field_folder = stage.Input("field");
  std::optional<std::string> why_not;
  try {
    const auto scene_folder = PreviousStage(field_folder, {"sfm", "import"});
    const SeenDepths seen_depths =
        RenderSeenDepths(stored, scene_folder, field_folder, bounds, options.device);
    const std::vector<SeenDepth>& views = seen_depths.views;
    LogInfo("level: where the rays of {} training views have lost {:.0f} % of their light",
            views.size(), 100 * (1 - std::exp(-seen_depths.optical_depth)));
    stage.Note("optical_depth", seen_depths.optical_depth);
    ReportConfirmedDepths(seen_depths, stage);
    ReportPassingRays(seen_depths, stage);
    stage.Device(seen_depths.device);
    const LevelSet all = MarchToOpacity(stored.mesh, views);
    if (options.close) return all;
    LevelSet seen = SeenPart(all, views, kLargestGap * glm::length(world.subject_bounds.Size()));
    const size_t unseen = all.triangles.size() - seen.triangles.size();
    LogInfo("{} of {} triangles are left out, because they face too few views or hang in rags",
            WithThousands(unseen), WithThousands(all.triangles.size()));
    stage.Count("unseen_triangles", unseen);
    return seen;
  } catch (const DataError& error) {
    if (options.level == SurfaceLevel::kOpacity) throw;
    why_not = error.what();
  } catch (const EnvironmentError& error) {
    // Who asks for a device wants what it gives.
    if (options.level == SurfaceLevel::kOpacity || options.device.device != "auto") throw;
    why_not = error.what();
  }
  stage.Degrade("the surface is a level of density instead of opacity: " + *why_not);
  return std::nullopt;
}

LevelSet ChosenSet(const RadianceField& stored, const FieldWorld& world, const Bounds3& bounds,
                   const SurfaceOptions& options, Stage& stage) {
  std::optional<LevelSet> by_opacity = OpacitySet(stored, world, bounds, options, stage);
  stage.Note("level", Name(by_opacity ? SurfaceLevel::kOpacity : SurfaceLevel::kDensity));
  return by_opacity ? std::move(*by_opacity) : DensitySet(stored, world, options, stage);
}

// What a box keeps of the surface and what it cuts off. Throws DataError if it keeps nothing.
CutSurface Cropped(const TriangleMesh& mesh, const Bounds3& crop, const ExportOptions& options,
                   const FieldWorld& world) {
  const Similarity3 export_from_world = ExportFromWorld(options, world.input_from_world);
  CutSurface cut = CutByBox(mesh, crop, export_from_world);
  if (cut.inside.triangles.empty()) {
    Bounds3 bounds;
    for (const glm::vec3& position : mesh.positions) {
      bounds.Add(export_from_world * glm::dvec3(position));
    }
    throw DataError(
        fmt::format("no part of the surface is inside the crop {}; in the coordinates of "
                    "surface.ply, it reaches from {:.4g},{:.4g},{:.4g} to {:.4g},{:.4g},{:.4g}",
                    fmt::join(options.crop, ","), bounds.min.x, bounds.min.y, bounds.min.z,
                    bounds.max.x, bounds.max.y, bounds.max.z));
  }
  return cut;
}

// The training photos of the scene that the field was fitted to. Nothing if they are not there, and
// the texture was not asked for by its size.
std::vector<TexturePhoto> ReadPhotos(const SurfaceOptions& options, Stage& stage) {
  if (!options.texture.wanted && options.align_rounds == 0) return {};
  const std::filesystem::path field = stage.Input("field");
  try {
    return ReadTexturePhotos(PreviousStage(field, {"sfm", "import"}), field);
  } catch (const DataError& error) {
    if (options.texture.size > 0) throw;
    stage.Degrade(
        fmt::format("no photos, so the surface stays as extracted, with only vertex colours: {}",
                    error.what()));
    return {};
  }
}

TriangleMesh Aligned(const TriangleMesh& mesh, std::span<const TexturePhoto> photos,
                     const SurfaceOptions& options, double max_smoothing_move, Stage& stage) {
  const Timer timer;
  AlignedSurface aligned =
      AlignWithPhotos(mesh, photos, options.align_rounds - MovesByTexture(options));
  LogInfo(
      "alignment: vertices moved by {:.2g} pixels on average; the surface in their colours is off "
      "by {:.1f} levels of 255 (root mean square)",
      aligned.mean_move_px, 255 * aligned.error);
  stage.Count("photo_alignment",
              {{"mean_move_px", aligned.mean_move_px}, {"error", aligned.error}});
  stage.Seconds("photo_alignment", timer.seconds());
  return SmoothByNormals(std::move(aligned.mesh),
                         {.rounds = std::min(options.smooth_normals, kRoundsAfterAlignment),
                          .max_move = max_smoothing_move});
}

// `cropped` is what a crop keeps of `raw`; null without one. `diagonal` is that of the subject's
// bounds.
TriangleMesh Cleaned(const TriangleMesh& raw, const TriangleMesh* cropped,
                     std::span<const TexturePhoto> photos, const SurfaceOptions& options,
                     const CleanOptions& clean, double diagonal, Stage& stage) {
  CleanResult kept = KeepLargePieces(SeparateFans(raw), clean, cropped);
  LogInfo("pieces: {} in all, {} dropped as small, {} as cavities ({} triangles)",
          WithThousands(kept.components), WithThousands(kept.dropped_small),
          WithThousands(kept.dropped_cavities), WithThousands(kept.dropped_triangles));
  if (kept.mesh.triangles.empty()) {
    throw DataError(
        "all pieces of the surface were dropped; keep them with --keep-cavities or a lower "
        "--min-component-share");
  }
  stage.Count("pieces", {{"all", kept.components},
                         {"dropped_small", kept.dropped_small},
                         {"dropped_cavities", kept.dropped_cavities},
                         {"dropped_triangles", kept.dropped_triangles}});
  const FilledHoles filled = FillSmallHoles(kept.mesh, options.fill_holes / 100 * diagonal);
  LogInfo("small holes: {} closed by {} triangles", WithThousands(filled.holes),
          WithThousands(filled.triangles));
  stage.Count("filled_holes", filled.holes);
  const TriangleMesh smooth = SmoothByNormals(
      filled.mesh, {.rounds = options.smooth_normals, .max_move = kMaxSmoothingMove * diagonal});
  TriangleMesh simple =
      Simplify(photos.size() < 2 || options.align_rounds == 0
                   ? smooth
                   : Aligned(Simplify(smooth, kDeviationBeforeAlignment * diagonal), photos,
                             options, kMaxSmoothingMove * diagonal, stage),
               options.max_deviation / 100 * diagonal);
  LogInfo("simplification: {} of {} triangles are left, within {:.3g} % of the subject's diagonal",
          WithThousands(simple.triangles.size()), WithThousands(filled.mesh.triangles.size()),
          options.max_deviation);
  stage.Count("triangles_before_simplification", filled.mesh.triangles.size());
  return simple;
}

// What is exported of the surface, and what a crop cuts off. Only what is exported counts as faces.
CutSurface Exported(const TriangleMesh& whole, const SurfaceOptions& options,
                    const CleanOptions& clean, const FieldWorld& world, Stage& stage) {
  CutSurface cut{whole, {}};
  if (const std::optional<Bounds3> crop = options.exports.Crop()) {
    cut = Cropped(whole, *crop, options.exports, world);
    LogInfo("crop: {} triangles are inside, {} outside are left out",
            WithThousands(cut.inside.triangles.size()),
            WithThousands(cut.outside.triangles.size()));
    stage.Count("triangles_out_of_crop", cut.outside.triangles.size());
    // Without the scraps that the box has cut from what is outside.
    cut.inside = KeepLargePieces(cut.inside, clean).mesh;
  }
  cut.inside = SeparateFans(cut.inside);
  if (options.max_faces == 0) return cut;
  cut.inside = Decimate(cut.inside, options.max_faces);
  if (const size_t left = cut.inside.triangles.size(); left > options.max_faces) {
    LogWarning(
        "{} triangles are left instead of {}, as fewer would tear the surface or its borders",
        WithThousands(left), WithThousands(options.max_faces));
  }
  return cut;
}

// A surface that will be cropped moves as a whole: the photos show all of it, and vertices of a
// part could leave the box.
TriangleMesh MovedByTexture(TriangleMesh whole, std::span<TexturePhoto> photos,
                            const SurfaceOptions& options, Stage& stage) {
  const int moves = MovesByTexture(options);
  if (moves == 0 || photos.size() < 2 || !options.exports.Crop()) return whole;
  try {
    return AlignByTexture(whole, photos, options.texture, moves, stage);
  } catch (const UsageError& error) {
    // There are too many charts; those of the part may be few enough.
    LogWarning("no alignment by the texture: {}", error.what());
  }
  return whole;
}

TexturedMesh Textured(TriangleMesh mesh_in_world, const TriangleMesh& hiding,
                      std::span<TexturePhoto> photos, const SurfaceOptions& options, Stage& stage) {
  if (!options.texture.wanted || photos.empty()) return {std::move(mesh_in_world), {}};
  const Timer timer;
  try {
    const int moves = options.exports.Crop() ? 0 : MovesByTexture(options);
    TexturedMesh textured =
        MakeTexture(mesh_in_world, hiding, photos, options.texture, moves, stage);
    stage.Seconds("texture", timer.seconds());
    return textured;
  } catch (const UsageError& error) {
    // Too many charts for the largest texture, whose size the user did not ask for.
    if (options.texture.size > 0) throw;
    LogWarning("no texture, only vertex colours, and no alignment by a texture: {}", error.what());
  }
  return {std::move(mesh_in_world), {}};
}

void Report(const TriangleMesh& mesh, Stage& stage) {
  const MeshFacts facts = MeasureMesh(mesh);
  LogInfo("surface: {} vertices, {} triangles, {} border edges, {} non-manifold edges",
          WithThousands(mesh.positions.size()), WithThousands(mesh.triangles.size()),
          WithThousands(facts.boundary_edges), WithThousands(facts.non_manifold_edges));
  stage.Count("vertices", mesh.positions.size());
  stage.Count("triangles", mesh.triangles.size());
  stage.Count("border_edges", facts.boundary_edges);
  stage.Count("non_manifold_edges", facts.non_manifold_edges);
  stage.Count("non_manifold_vertices", facts.non_manifold_vertices);
  stage.Count("euler_characteristic", facts.euler_characteristic);
  stage.Count("area", facts.area);
}

}  // namespace

void SurfaceOptions::Check() const {
  if (isovalue != 0) CheckRange("isovalue", isovalue, 1e-30, 1e30);
  if (level == SurfaceLevel::kOpacity && isovalue > 0) {
    throw UsageError(fmt::format(
        "isovalue is {}, but the level is opacity; choose density as level, or no isovalue",
        isovalue));
  }
  if (close && (level == SurfaceLevel::kDensity || isovalue > 0)) {
    throw UsageError(
        "close has an effect on the level of opacity only; leave it out, or level and isovalue");
  }
  CheckRange("smoothing", smoothing, 0, 100);
  CheckRange("align_rounds", align_rounds, 0, 100);
  CheckRange("smooth_normals", smooth_normals, 0, 100);
  CheckRange("margin", margin, 0.0, 10.0);
  CheckRange("fill_holes", fill_holes, 0.0, 1000.0);
  CheckRange("max_deviation", max_deviation, 0.0, 10.0);
  CheckRange("min_component_share", clean.min_component_share, 0.0, 1.0);
  exports.Check();
  CheckRange("rays", rays, 100, 100'000'000);
}

void RunSurface(const SurfaceOptions& options, Stage& stage) {
  const RadianceField stored = ReadField(stage.Input("field") / "field.tetf", Orientations::kAny);
  if (const uint64_t degenerate = CountDegenerateTets(stored.mesh); degenerate > 0) {
    LogWarning("{} of {} tets are inside out or flat: the surface may cross itself there",
               degenerate, stored.mesh.tets.size());
  }
  const FieldWorld world = ReadFieldWorld(stage.Input("field") / kFieldWorldFile);
  CheckFloatsSuffice(options.exports, world.input_from_world, world.subject_bounds);
  CheckCropHasTets(options.exports, world.input_from_world, stored.mesh);
  const std::optional<ExportedScene> cameras =
      SceneToExport(options.exports, stage.Input("field"),
                    ExportFromWorld(options.exports, world.input_from_world));
  const Timer timer;
  const Bounds3 bounds = world.subject_bounds.Scaled(1 + 2 * options.margin);
  LevelSet set = ChosenSet(stored, world, bounds, options, stage);
  const size_t triangles = set.triangles.size();
  if (options.extent == SurfaceExtent::kSubject) set = CropTo(set, bounds);
  LogInfo("level set: {} triangles, of which {} lie outside the subject's bounds and are left out",
          WithThousands(triangles), WithThousands(triangles - set.triangles.size()));
  stage.Count("triangles_out_of_bounds", triangles - set.triangles.size());
  if (set.triangles.empty()) {
    throw DataError("no surface there; choose another level or isovalue, or all as extent");
  }
  const TriangleMesh raw = ColoredSurface(set, WithStorage(stored, FieldStorage::kVertex));
  std::optional<TriangleMesh> cropped;
  if (const std::optional<Bounds3> crop = options.exports.Crop()) {
    // Before alignment, so that a crop of nothing is refused early.
    cropped = Cropped(raw, *crop, options.exports, world).inside;
  }
  std::vector<TexturePhoto> photos = ReadPhotos(options, stage);
  // Photos show the whole, so it is cropped after alignment.
  CleanOptions clean = options.clean;
  clean.cameras = world.cameras_in_world;
  const TriangleMesh cleaned = Cleaned(raw, cropped ? &*cropped : nullptr, photos, options, clean,
                                       world.subject_bounds.Diagonal(), stage);
  const TriangleMesh whole = MovedByTexture(cleaned, photos, options, stage);
  const CutSurface cut = Exported(whole, options, clean, world, stage);
  stage.Seconds("surface", timer.seconds());
  TexturedMesh surface = Textured(cut.inside, cut.outside, photos, options, stage);
  surface.mesh = Transformed(std::move(surface.mesh),
                             ExportFromWorld(options.exports, world.input_from_world));
  Report(surface.mesh, stage);
  WriteExports(surface, stored, world.input_from_world, options.exports, stage);
  if (cameras) WriteCameraExports(*cameras, options.exports, stage);
}

}  // namespace tetrec
