// tetrec-render: pictures of a finished field, beside the ground truth.
#include "render/render_views.h"
#include "render/renderer_command.h"

int main(int argc, char** argv) {
  tetrec::RenderViewsOptions options;
  tetrec::StageCommand command("render", 1, "Renders views of a field that tetrec-optimize made.");
  command.InputStage("FIELD", "folder of tetrec-optimize", {"optimize"});
  CLI::App& app = command.app();
  app.add_option("--views", options.views, "which views: heldout, train or all")
      ->check(CLI::IsMember({"heldout", "train", "all"}));
  app.add_option("--samples", options.samples, "rays a pixel side; 2 is 4 rays a pixel")
      ->check(CLI::Range(1, 16));
  app.add_option("--background", options.background,
                 "what stands behind pictures with alpha: scene (as imported), white, black")
      ->check(CLI::IsMember({"scene", "white", "black"}));
  tetrec::AddRendererOptions(command, options.renderer);
  return command.Run(argc, argv, [&](tetrec::Stage& stage) { RunRenderViews(options, stage); });
}
