// tetrec-surface: the level set of a field's density as a coloured triangle mesh.
#include "core/error.h"
#include "core/log.h"
#include "core/option_checks.h"
#include "core/progress.h"
#include "core/stage.h"
#include "field/change_storage.h"
#include "field/radiance_field.h"
#include "surface/clean.h"
#include "surface/field_world.h"
#include "surface/level.h"
#include "surface/marching_tetrahedra.h"
#include "surface/measure.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

// Rays lose half of their light inside a wall; the wall begins where density has risen to this
// share of what it is there. Free space has far less.
constexpr double kWallBegins = 0.1;

struct SurfaceOptions {
  double isovalue = 0;  // 0: kWallBegins of the density where rays have lost half of their light
  std::string bounds = "subject";
  double margin = 0.05;
  CleanOptions clean;
  uint64_t max_faces = 0;
  int rays = 10000;
  uint64_t seed = 1;
};

void AddOptions(CLI::App& app, SurfaceOptions& options) {
  app.add_option(
         "--isovalue", options.isovalue,
         "density of the surface [1 / world unit]; 0: a tenth of the typical density where a "
         "ray from a camera has lost half of its light")
      ->check(tetrec::AtLeastZero());
  app.add_option("--bounds", options.bounds, "extract the subject only, or all of the volume")
      ->check(CLI::IsMember({"subject", "all"}));
  app.add_option("--margin", options.margin,
                 "room around the subject's bounds, in shares of their sides")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--min-component-share", options.clean.min_component_share,
                 "drop pieces with less than this share of the largest piece's area")
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag("--keep-cavities", options.clean.keep_cavities,
               "keep closed pieces that face inward, which no view from outside sees");
  app.add_option("--max-faces", options.max_faces, "simplify to this many triangles; 0: keep all");
  app.add_option("--rays", options.rays, "rays that find the isovalue")
      ->check(CLI::Range(100, 100000000));
  app.add_option("--seed", options.seed, "seed of those rays");
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
      "isovalue: {:.4g} per world unit, a tenth of the density where {} of {} rays have lost half "
      "of "
      "their light ({} lost)",
      isovalue, WithThousands(level.opaque_rays), WithThousands(level.rays), level.lost_rays);
  stage.Count("isovalue_rays",
              {{"cast", level.rays}, {"opaque", level.opaque_rays}, {"lost", level.lost_rays}});
  return float(isovalue);
}

TriangleMesh Cleaned(const TriangleMesh& raw, const SurfaceOptions& options, Stage& stage) {
  CleanResult kept = KeepLargePieces(SeparateFans(raw), options.clean);
  LogInfo("pieces: {} in all, {} dropped as small, {} as cavities ({} triangles)",
          WithThousands(kept.components), WithThousands(kept.dropped_small),
          WithThousands(kept.dropped_cavities), WithThousands(kept.dropped_triangles));
  stage.Count("pieces", {{"all", kept.components},
                         {"dropped_small", kept.dropped_small},
                         {"dropped_cavities", kept.dropped_cavities},
                         {"dropped_triangles", kept.dropped_triangles}});
  if (options.max_faces == 0) return std::move(kept.mesh);
  return Decimate(kept.mesh, options.max_faces);
}

void Report(const TriangleMesh& mesh, Stage& stage) {
  const SurfaceFacts facts = MeasureSurface(mesh);
  LogInfo("surface: {} vertices, {} triangles, {} border edges, {} non-manifold edges",
          WithThousands(mesh.positions.size()), WithThousands(mesh.triangles.size()),
          WithThousands(facts.border_edges), WithThousands(facts.non_manifold_edges));
  stage.Count("vertices", mesh.positions.size());
  stage.Count("triangles", mesh.triangles.size());
  stage.Count("border_edges", facts.border_edges);
  stage.Count("non_manifold_edges", facts.non_manifold_edges);
  stage.Count("non_manifold_vertices", facts.non_manifold_vertices);
  stage.Count("euler_characteristic", facts.euler_characteristic);
  stage.Count("area", facts.area);
}

void RunSurface(const SurfaceOptions& options, Stage& stage) {
  // The level function is linear in each tet: densities of cells become means at their vertices.
  const RadianceField field =
      WithStorage(ReadField(stage.Input("field") / "field.tetf"), FieldStorage::kVertex);
  const FieldWorld world = ReadFieldWorld(stage.Input("field") / "world.json");
  const Timer timer;
  const float isovalue = ChooseIsovalue(field, world, options, stage);
  stage.Note("isovalue", isovalue);
  LevelSet set = MarchTetrahedra(field.mesh, field.density, isovalue);
  LogInfo("level set: {} triangles", WithThousands(set.triangles.size()));
  if (options.bounds == "subject") {
    set = CropTo(set, world.subject_bounds.Scaled(1 + 2 * options.margin));
  }
  if (set.triangles.empty()) {
    throw DataError(fmt::format(
        "no surface at isovalue {:.4g}: give another --isovalue, or --bounds all", isovalue));
  }
  const TriangleMesh mesh =
      Transformed(Cleaned(ColoredSurface(set, field), options, stage), world.input_from_world);
  stage.Seconds("surface", timer.seconds());
  Report(mesh, stage);
  stage.Note("coordinates", "the input's own");
  WriteTriangleMeshPly(stage.Output("surface.ply"), mesh);
  WriteTriangleMeshObj(stage.Output("surface.obj"), mesh);
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  tetrec::StageCommand command(
      "surface", 1,
      "Extracts the surface of a field: writes surface.ply and surface.obj, "
      "with vertex colours, in the input's own coordinates.");
  tetrec::SurfaceOptions options;
  command.InputStage("field", "folder that tetrec-optimize wrote", {"optimize"});
  tetrec::AddOptions(command.app(), options);
  return command.Run(argc, argv, [&](tetrec::Stage& stage) { tetrec::RunSurface(options, stage); });
}
