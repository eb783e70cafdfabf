// tetrec-evaluate: measures the quality of images and meshes on disk; renders nothing.
#include "eval/evaluate.h"

#include "command/help.h"
#include "command/stage_command.h"
#include "core/error.h"
#include "core/stage.h"

int main(int argc, char** argv) {
  tetrec::EvaluateOptions options;
  tetrec::StageCommand command(
      "evaluate", 9,
      "Measures the quality of rendered views (PSNR, SSIM) and of a surface (accuracy, "
      "completeness, F-score), and writes metrics.json and a self-contained report.html.\n"
      "Example: tetrec-evaluate RUN/4_views RUN/5_surface -o RUN/6_report");
  command.InputStage("VIEWS", "Folder that tetrec-render wrote", {"render"});
  command.InputStage("SURFACE", "Folder that tetrec-surface wrote", {"surface"}, false);
  command.InputPath("--ground-truth", "True mesh (PLY) to compare the surface with", false);
  command.InputPath(
      "--cameras",
      "True cameras (JSON) in the frame of the true mesh; the reconstruction is aligned to them. "
      "Default: the input and the true mesh have the same frame",
      false);
  command.InputPath("--depth-maps",
                    "NeRF-synthetic data set whose depth maps (test/r_0_depth_0001.png) judge the "
                    "rendered depth, and its normal maps the normals; without them the true mesh "
                    "of --ground-truth does",
                    false);
  CLI::App& app = command.app();
  CLI::Option* bounds =
      app.add_option(
             "--ground-truth-bounds", options.ground_truth_bounds,
             "xmin,ymin,zmin,xmax,ymax,zmax: compare only inside this box, in the true mesh's "
             "units. Default: its bounding box, enlarged by 5 %, along thin sides by 5 % of those "
             "of a cube of its diagonal")
          ->expected(6)
          ->delimiter(',')
          ->needs("--ground-truth");
  bounds->default_str("");
  app.add_option("--threshold", options.threshold_percent,
                 "Largest distance that counts as a match [% of the subject's diagonal]")
      ->needs("--ground-truth")
      ->capture_default_str();
  app.add_option("--surface-samples", options.surface_samples, "Points sampled on each surface")
      ->needs("--ground-truth")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Random seed of the surface samples")
      ->needs("--ground-truth")
      ->capture_default_str();
  app.get_option("--ground-truth")->needs("SURFACE");
  app.get_option("--cameras")->needs("--ground-truth");
  tetrec::GroupOptions(app, "Comparison with the truth",
                       {"--ground-truth", "--cameras", "--depth-maps", "--ground-truth-bounds",
                        "--threshold", "--surface-samples", "--seed"});
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { Evaluate(options, stage); },
      [&] { options.Check(); });
}
