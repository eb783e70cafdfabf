// tetrec-render: pictures of a finished field, beside the ground truth.
#include "render/render_views.h"

int main(int argc, char** argv) {
  tetrec::RenderViewsOptions options;
  std::string integral = "exact";
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
  app.add_option(
      "--integral", integral,
      "colour of a ray inside a tet: exact (linear density), mean (mean density) or split:N "
      "(N = 1 .. 64 equal parts of constant density); opacity is exact in all of them");
  command.DoesNotChangeResults(app.add_option("--device", options.renderer.device.device,
                                              "Vulkan device: auto, cpu, gpu or a number"));
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunRenderViews(options, stage); },
      [&] { options.renderer.integral = tetrec::ParseIntegral(integral); });
}
