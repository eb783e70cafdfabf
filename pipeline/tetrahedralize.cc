// tetrec-tetrahedralize: the first tetrahedral mesh of a scene, with the field that optimisation
// starts from.
#include "start/tetrahedralize.h"

#include "command/help.h"
#include "command/option_checks.h"
#include "command/stage_command.h"
#include "command/word_option.h"

#include <fmt/format.h>

#include <optional>
#include <string>

namespace {

constexpr auto kOfDepths = {"--dense-points",  "--depth-size",    "--depth-neighbors",
                            "--surface-depth", "--layer-spacing", "--free-depth"};
constexpr auto kOfPoints = {"--max-reprojection-error", "--min-track-length", "--min-spacing",
                            "--sphere-points", "--far-share"};
constexpr auto kOfMasksOrBox = {"--resolution", "--outer-points", "--start-density"};

// A start by depth maps takes sparse points, too. Automatic starts may be any.
void RefuseOptionsOfOtherStarts(const CLI::App& app, std::optional<tetrec::StartKind> start) {
  using tetrec::RefuseOptions, tetrec::StartKind;
  if (!start) return;
  const std::string why = fmt::format("has no effect with --start {}; leave it out", Name(*start));
  const bool by_points = *start == StartKind::kDense || *start == StartKind::kPoints;
  if (*start != StartKind::kDense) RefuseOptions(app, kOfDepths, why);
  if (!by_points) RefuseOptions(app, kOfPoints, why);
  if (by_points) RefuseOptions(app, kOfMasksOrBox, why);
  if (*start != StartKind::kCarve) RefuseOptions(app, {"--outer-points"}, why);
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::StageCommand command(
      "tetrahedralize", 8,
      "Fills a scene with tetrahedra: writes the mesh (mesh.tet), and the first density and colour "
      "of its vertices (field.tetf).\n"
      "Example: tetrec-tetrahedralize RUN/1_scene -o RUN/2_tetrahedra");
  tetrec::TetrahedralizeOptions options;
  command.InputStage("scene", "Folder that tetrec-sfm or tetrec-import wrote", {"sfm", "import"});
  CLI::App& app = command.app();
  AddWordOption(app, "--start", options.start, "auto",
                "Where the first vertices come from: dense (depth maps of the training photos, and "
                "layers around their points), points (sparse points, a fill and a far "
                "shell), carve (alpha masks), grid (the subject's bounds), tetgen (the bounds, "
                "meshed by TetGen); auto: for images with alpha, points if the scene has any, "
                "otherwise carve; for others dense, or points or grid where their depths do not "
                "agree");
  app.add_option("--seed", options.seed, "Random seed of jitter and of random vertices");
  app.add_option("--resolution", options.resolution,
                 "carve, grid, tetgen: cells along the longest side, at most 512; 0: 64, 32, 24");
  app.add_option("--max-reprojection-error", options.filter.max_reprojection_error_px,
                 "points, dense: drop sparse points with a larger reprojection error [px]");
  app.add_option("--min-track-length", options.filter.min_track_length,
                 "points, dense: drop sparse points that fewer views see");
  app.add_option(
      "--min-spacing", options.filter.min_spacing,
      "points, dense: keep one of several points that are closer than this [world units; the "
      "subject's longest side is 2]");
  app.add_option(
      "--sphere-points", options.shell.sphere_points,
      "points, dense: vertices on each sphere of the fill, 20 to 100000; the far shell has "
      "twice as many");
  app.add_option(
      "--far-share", options.shell.far_share,
      "points, dense: share of the sparse points that the dense part of the fill encloses, 0 to 1");
  app.add_option("--outer-points", options.carve.outer_points,
                 "carve: random vertices in the free space of the box, at most 1000000");
  app.add_option("--start-density", options.field.density,
                 "carve, grid, tetgen: first density of the subject [1 / world unit]");
  app.add_option("--dense-points", options.stereo.fusion.max_points,
                 "dense: surface points from the depth maps, at most; each adds up to three "
                 "vertices; 0: one per 100 pixels of the photos, 2,000 to 40,000");
  app.add_option("--depth-size", options.stereo.max_size,
                 "dense: longer side of the depth maps, at most the images' own [px]");
  app.add_option("--depth-neighbors", options.stereo.neighbors,
                 "dense: views that each view is matched with, 1 to 32");
  app.add_option(
      "--surface-depth", options.dense.surface_depth,
      "dense: density of surface points at the start, as optical depth over their mean edge");
  app.add_option("--layer-spacing", options.dense.layer_spacing,
                 "dense: distance of the layers from the points, in the points' spacing");
  app.add_option("--free-depth", options.dense.free_depth,
                 "dense: first optical depth of vertices in free space over their mean edge");
  using tetrec::GroupOptions;
  GroupOptions(app, "Start", {"--start", "--seed"});
  GroupOptions(app, "Start from depth maps", kOfDepths);
  GroupOptions(app, "Start from sparse points", kOfPoints);
  GroupOptions(app, "Start from masks or a box", kOfMasksOrBox);
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunTetrahedralize(options, stage); },
      [&] {
        RefuseOptionsOfOtherStarts(app, options.start);
        options.Check();
      });
}
