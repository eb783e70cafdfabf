// tetrec-render: images of a finished field, with the ground truth beside them.
#include "command/help.h"
#include "command/stage_command.h"
#include "command/word_option.h"
#include "core/stage.h"
#include "render/render_views.h"
#include "renderer_options.h"

int main(int argc, char** argv) {
  tetrec::RenderViewsOptions options;
  tetrec::StageCommand command(
      "render", 3,
      "Renders views of a fitted field: writes images and depth maps with the ground truth beside "
      "them, and views.json.\n"
      "Example: tetrec-render RUN/3_field -o RUN/4_views");
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
  tetrec::GroupOptions(app, "Views", {"--views", "--samples", "--background", "--refine-cameras"});
  AddRendererOptions(command, options.renderer);
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunRenderViews(options, stage); },
      [&] { options.renderer.Check(); });
}
