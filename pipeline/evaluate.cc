// tetrec-evaluate: judges pictures and meshes on disk; renders nothing.
#include "eval/evaluate.h"

#include "core/error.h"

int main(int argc, char** argv) {
  tetrec::EvaluateOptions options;
  tetrec::StageCommand command(
      "evaluate", 1,
      "Judges rendered views (PSNR, SSIM) and a surface (accuracy, completeness, F-score) and "
      "writes\n"
      "metrics.json and a self-contained report.html.\n"
      "Example: tetrec-evaluate RUN/4_views RUN/5_surface -o RUN/6_report");
  command.InputStage("VIEWS", "Folder that tetrec-render wrote", {"render"});
  command.InputStage("SURFACE", "Folder that tetrec-surface wrote", {"surface"}, false);
  command.InputPath("--ground-truth", "True mesh (PLY) to judge the surface by", false);
  command.InputPath(
      "--cameras",
      "True cameras (JSON) in the true mesh's frame; the reconstruction is aligned to "
      "them. Without: the input's coordinates are the true mesh's",
      false);
  CLI::App& app = command.app();
  CLI::Option* bounds =
      app.add_option(
             "--ground-truth-bounds", options.ground_truth_bounds,
             "XMIN YMIN ZMIN XMAX YMAX ZMAX: judge only what lies inside, in the true mesh's "
             "units. Without: its bounding box grown by 5 %")
          ->expected(6)
          ->needs("--ground-truth");
  bounds->default_str("");
  app.add_option("--threshold", options.threshold_percent,
                 "Distance that counts as found [% of the subject's diagonal]")
      ->capture_default_str();
  app.add_option("--surface-samples", options.surface_samples, "Points on each surface")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of the surface samples")->capture_default_str();
  app.get_option("--ground-truth")->needs("SURFACE");
  app.get_option("--cameras")->needs("--ground-truth");
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { Evaluate(options, stage); },
      [&] { options.Check(); });
}
