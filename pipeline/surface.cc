// tetrec-surface: the level set of a field's density as a coloured triangle mesh.
#include "surface/surface.h"

#include "command/help.h"
#include "command/stage_command.h"
#include "command/word_option.h"

int main(int argc, char** argv) {
  tetrec::StageCommand command(
      "surface", 2,
      "Extracts the surface of a field: writes surface.ply and surface.obj, with vertex colours, "
      "in the input's own coordinates.\n"
      "Example: tetrec-surface RUN/3_field -o RUN/5_surface");
  tetrec::SurfaceOptions options;
  command.InputStage("field", "Folder that tetrec-optimize wrote", {"optimize"});
  CLI::App& app = command.app();
  app.add_option("--isovalue", options.isovalue,
                 "Density of the surface [1 / world unit]; 0: a fiftieth of the typical density "
                 "where a ray from a camera has lost half of its light");
  app.add_option(
      "--smoothing", options.smoothing,
      "Rounds in which each vertex is averaged with its neighbours before the surface is "
      "extracted, 0 to 100");
  AddWordOption(app, "--bounds", options.bounds, "Extract the subject only, or the whole volume");
  app.add_option("--margin", options.margin,
                 "Margin around the subject's bounds, in shares of their sides, 0 to 10");
  app.add_option("--min-component-share", options.clean.min_component_share,
                 "Drop pieces with less than this share of the largest piece's area, 0 to 1");
  app.add_flag("--keep-cavities", options.clean.keep_cavities,
               "Keep closed pieces that face inward, which no view from outside sees");
  app.add_option("--max-faces", options.max_faces, "Simplify to this many triangles; 0: keep all");
  app.add_option("--rays", options.rays, "Rays that find the isovalue, 100 or more");
  app.add_option("--seed", options.seed, "Random seed of those rays");
  using tetrec::GroupOptions;
  GroupOptions(app, "Level", {"--isovalue", "--smoothing", "--rays", "--seed"});
  GroupOptions(app, "Part of the surface",
               {"--bounds", "--margin", "--min-component-share", "--keep-cavities", "--max-faces"});
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunSurface(options, stage); },
      [&] { options.Check(); });
}
