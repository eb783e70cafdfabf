// tetrec-render: images of a finished field, with the ground truth beside them, or a video.
#include "command/help.h"
#include "command/option_checks.h"
#include "command/stage_command.h"
#include "command/word_option.h"
#include "core/stage.h"
#include "render/render_path.h"
#include "renderer_options.h"

int main(int argc, char** argv) {
  tetrec::RenderViewsOptions options;
  tetrec::RenderPathOptions path;
  tetrec::StageCommand command(
      "render", 9,
      "Renders views of a fitted field: writes images, depth and normal maps with the ground truth "
      "beside them, and views.json. With --path it writes a video of a moving camera instead.\n"
      "Examples: tetrec-render RUN/3_field -o RUN/4_views\n"
      "          tetrec-render RUN/3_field -o RUN/video --path orbit");
  command.InputStage("FIELD", "Folder that tetrec-optimize wrote", {"optimize"});
  CLI::App& app = command.app();
  app.add_option("--views", options.views, "Views to render: heldout, train or all")
      ->check(CLI::IsMember({"heldout", "train", "all"}));
  app.add_option("--samples", options.samples, "Rays per side of a pixel; 2 gives 4 rays per pixel")
      ->check(CLI::Range(1, 16));
  app.add_option("--background", options.background,
                 "Background of images with alpha: scene (as imported), white or black")
      ->check(CLI::IsMember({"scene", "white", "black"}));
  tetrec::AddWordOption(app, "--refine-cameras", options.refine_cameras,
                        "Also render each view from a camera whose pose is fitted to the true "
                        "image, as a second number: auto (if the training cameras were corrected), "
                        "on or off");
  tetrec::AddWordOption(
      app, "--path", path.path,
      "Write video.mp4 instead, of a camera that moves: none, orbit (once around the subject) or "
      "cameras (through the cameras that --views selects)");
  CLI::Option* seconds = app.add_option("--seconds", path.seconds, "Length of the video [s]");
  app.add_option("--frames", path.frames, "Number of frames, instead of --seconds")
      ->excludes(seconds);
  app.add_option("--fps", path.fps, "Frames per second");
  app.add_option("--size", path.size,
                 "Longer side of the video [pixels]; 0: as the scene's images");
  tetrec::GroupOptions(app, "Video", {"--path", "--seconds", "--frames", "--fps", "--size"});
  tetrec::GroupOptions(app, "Views", {"--views", "--samples", "--background", "--refine-cameras"});
  AddRendererOptions(command, options.renderer);
  command.DoesNotChangeResults(app.get_option("--device"));
  return command.Run(
      argc, argv,
      [&](tetrec::Stage& stage) {
        if (path.path == tetrec::CameraPath::kNone) {
          RunRenderViews(options, stage);
        } else {
          RunRenderPath(path, options, stage);
        }
      },
      [&] {
        if (path.path == tetrec::CameraPath::kNone) {
          tetrec::RefuseOptions(app, {"--seconds", "--frames", "--fps", "--size"},
                                "is for videos; add --path orbit or cameras, or leave it out");
        } else {
          tetrec::RefuseOptions(app, {"--refine-cameras"},
                                "is for views, but --path makes a video; leave one of them out");
        }
        if (path.path == tetrec::CameraPath::kOrbit) {
          tetrec::RefuseOptions(
              app, {"--views"},
              "has no effect on an orbit, which goes by all cameras; leave it out");
        }
        options.renderer.Check();
        path.Check();
      });
}
