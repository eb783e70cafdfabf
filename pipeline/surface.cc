// tetrec-surface: the level set of a field's opacity or density as a coloured triangle mesh.
#include "surface/surface.h"

#include "command/help.h"
#include "command/option_checks.h"
#include "command/stage_command.h"
#include "command/word_option.h"

int main(int argc, char** argv) {
  tetrec::StageCommand command(
      "surface", 22,
      "Extracts the surface of a field, with vertex colours and a texture, and writes it, and the "
      "field if asked "
      "for, in formats of other programs. The files have the run's world as coordinates: z is up, "
      "the subject's centre is 0 and its longest side is 2; OBJ and GLB have y up.\n"
      "Example: tetrec-surface RUN/3_field -o RUN/5_surface");
  tetrec::SurfaceOptions options;
  command.InputStage("field", "Folder that tetrec-optimize wrote", {"optimize"});
  CLI::App& app = command.app();
  AddWordOption(app, "--level", options.level,
                "What the surface is a level of: opacity (where the training cameras' rays have "
                "lost a third of their light, or more of it if the field is hazy), density, or "
                "auto (opacity, but density with --isovalue or where the scene or Vulkan is "
                "missing)");
  app.add_option(
      "--isovalue", options.isovalue,
      "density: density of the surface [1 / world unit]; 0: a fiftieth of the typical density "
      "where a ray from a camera has lost half of its light");
  app.add_option(
      "--smoothing", options.smoothing,
      "density: rounds in which each vertex is averaged with its neighbours before the surface is "
      "extracted, 0 to 100");
  app.add_flag("--close", options.close,
               "Opacity: keep what closes the surface through space that no camera sees");
  app.add_option(
      "--align-rounds", options.align_rounds,
      "Rounds in which the surface moves to where its pictures differ least from the photos, 0 to "
      "100. With a texture, up to half of them, and at most four, use its colours. 0: leave the "
      "surface at the level");
  app.add_option(
      "--smooth-normals", options.smooth_normals,
      "Rounds in which the triangles' normals are averaged with similar ones around them, "
      "so that ripples go and edges stay, 0 to 100; 0: leave the surface as extracted");
  AddWordOption(app, "--extent", options.extent, "Extract the subject only, or the whole volume");
  app.add_option("--margin", options.margin,
                 "Margin around the subject's bounds, in shares of their sides, 0 to 10");
  app.add_option("--min-component-share", options.clean.min_component_share,
                 "Drop pieces with less than this share of the largest piece's area, 0 to 1");
  app.add_flag("--keep-cavities", options.clean.keep_cavities,
               "Keep closed pieces that face inward, which no view from outside sees");
  app.add_option("--fill-holes", options.fill_holes,
                 "Close holes of up to this perimeter [% of the subject's diagonal]; 0: none");
  app.add_option("--max-deviation", options.max_deviation,
                 "Simplify as long as no vertex ends farther than this from the surface [% of the "
                 "subject's diagonal]; 0: keep all triangles");
  app.add_option(
      "--max-faces", options.max_faces,
      "Simplify what is exported further, to this many triangles, however far they move; "
      "0: do not");
  AddParsedOption(
      app, "--texture", options.texture, &tetrec::ParseTextureChoice, "auto",
      "Texture from the training photos: auto (at least as fine as the median pixel of the best "
      "photos on the surface, up to 4096 x 4096), off (vertex colours only), or the side of a "
      "square image, 64 to 8192 [texels]");
  AddWordsOption(
      app, "--formats", options.exports.formats,
      "Files to write, with commas between them. The surface: ply (always written, "
      "because tetrec-evaluate reads it), obj, glb, stl. The field: vtu (ParaView), mesh "
      "(MEDIT), msh (Gmsh). The cameras, as the fit corrected them, and sparse points: colmap "
      "(sparse/0), transforms (transforms.json)");
  AddWordOption(app, "--coordinates", options.exports.coordinates,
                "Coordinates of the files: the run's world, or those of the input");
  CLI::Option* scale = app.add_option("--scale", options.exports.scale,
                                      "Multiplies the coordinates of all files, 1e-9 to 1e9");
  app.add_option("--known-distance", options.exports.known_distance,
                 "x0,y0,z0,x1,y1,z1,d: two points of a PLY file that was written without scaling, "
                 "and their true distance; scales all files so that the distance is d")
      ->delimiter(',')
      ->expected(7)
      ->excludes(scale);
  app.add_option(
         "--crop", options.exports.crop,
         "x0,y0,z0,x1,y1,z1: export only what is inside this box, in the coordinates of the "
         "PLY file; triangles are cut at its faces; --extent all lets it reach beyond the subject")
      ->delimiter(',')
      ->expected(6);
  app.add_option("--rays", options.rays, "density: rays that find the isovalue, 100 or more");
  app.add_option("--seed", options.seed, "Random seed of those rays");
  command.DoesNotChangeResults(app.add_option(
      "--device", options.device.device,
      "opacity: Vulkan device that renders depths: auto, cpu, gpu or a number; one that is "
      "missing is an error"));
  using tetrec::GroupOptions;
  GroupOptions(app, "Level",
               {"--level", "--isovalue", "--smoothing", "--align-rounds", "--smooth-normals",
                "--rays", "--seed", "--device"});
  GroupOptions(app, "Part of the surface",
               {"--extent", "--margin", "--min-component-share", "--close", "--keep-cavities",
                "--fill-holes"});
  GroupOptions(app, "Simplification", {"--max-deviation", "--max-faces"});
  GroupOptions(
      app, "Files",
      {"--texture", "--formats", "--coordinates", "--scale", "--known-distance", "--crop"});
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunSurface(options, stage); },
      [&] {
        if (options.level == tetrec::SurfaceLevel::kOpacity) {
          tetrec::RefuseOptions(app, {"--smoothing", "--rays", "--seed"},
                                "has no effect with --level opacity; leave it out");
        }
        options.Check();
      });
}
