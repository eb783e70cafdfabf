// tetrec-optimize: fits the radiance field to the pictures, coarse to fine.
#include "core/option_checks.h"
#include "core/word_option.h"
#include "optimize/trainer.h"
#include "render/renderer_words.h"

namespace {

// Options that the command line gives as words.
struct Words {
  std::string loss = "l2", background = "random";
  tetrec::RendererWords renderer;
};

void AddOptions(tetrec::StageCommand& command, tetrec::OptimizeOptions& options, Words& words) {
  CLI::App& app = command.app();
  app.add_option("--time-limit", options.time_limit_s,
                 "seconds of optimisation, refinement included; 0: no limit, by --iterations");
  app.add_option("--iterations", options.iterations, "steps; 0: by --time-limit");
  app.add_option("--seed", options.seed, "seed of all that is drawn");
  app.add_option("--rays", options.rays_per_step, "rays a step");
  app.add_option("--loss", words.loss,
                 "l2 (highest PSNR), l1 (sharper, robust to outliers), or either with a share of "
                 "D-SSIM, (1 - SSIM) / 2: l1+dssim:0.2 is 0.8 l1 + 0.2 D-SSIM");
  tetrec::AddWordOption(
      app, "--storage", options.storage,
      "where density and colour live: vertex (linear inside each tet) or cell (one of each a tet, "
      "constant inside)");
  app.add_option("--color-rate", options.color_rate, "first learning rate of colour [display sRGB]")
      ->check(tetrec::AboveZero());
  app.add_option("--density-rate", options.density_rate,
                 "first learning rate of the logarithm of density")
      ->check(tetrec::AboveZero());
  app.add_option("--final-rate-share", options.schedule.final_rate_share,
                 "learning rates fall exponentially to this share")
      ->check(CLI::Range(1e-6, 1.0));
  app.add_option("--max-density", options.max_density, "upper bound of density [1 / world unit]");
  app.add_option("--density-decay", options.density_decay,
                 "pull of seen vertices towards empty, as a share of Adam's largest step")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--jitter", options.jitter_px,
                 "rays move inside their pixel by up to half of this [px]")
      ->check(CLI::Range(0.0, 2.0));
  app.add_option("--subject-share", options.subject_share,
                 "share of the rays drawn where the masks show something")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--background", words.background,
                 "behind pictures with alpha: random (another colour each step, which tells empty "
                 "from background-coloured) or scene (as imported)")
      ->check(CLI::IsMember({"random", "scene"}));
  app.add_option("--rounds", options.schedule.rounds, "refinements of the mesh")
      ->check(CLI::Range(0, 100));
  app.add_option("--last-round", options.schedule.last_round,
                 "share of the run before the last refinement")
      ->check(CLI::Range(0.01, 1.0));
  app.add_option("--max-vertices", options.max_vertices,
                 "vertices that refinement may reach; 0: what the time affords");
  app.add_option("--score-rays", options.score_rays_per_tet,
                 "rays per tet in a refinement's look at the errors")
      ->check(tetrec::AboveZero());
  app.add_option("--watched-views", options.watched_views,
                 "held-out views whose PSNR goes into metrics.csv")
      ->check(CLI::Range(0, 1000));
  app.add_flag("--deterministic", options.renderer.deterministic,
               "the same bytes for any number of threads and after a resume, a little slower; with "
               "--iterations and --time-limit 0");
  command.DoesNotChangeResults(app.add_option("--checkpoint-interval",
                                              options.checkpoint_interval_s,
                                              "seconds between checkpoints")
                                   ->check(tetrec::AtLeastZero()));
  AddRendererOptions(command, words.renderer, options.renderer);
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::OptimizeOptions options;
  Words words;
  tetrec::StageCommand command(
      "optimize", 1, "Fits density and colour on a tet mesh to the pictures of its scene.");
  command.InputStage("TETRAHEDRA", "folder of tetrec-tetrahedralize", {"tetrahedralize"});
  AddOptions(command, options, words);
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunOptimize(options, stage); },
      [&] {
        options.loss = tetrec::ParseLoss(words.loss);
        options.random_background = words.background == "random";
        words.renderer.Apply(options.renderer);
        options.Check();
      });
}
