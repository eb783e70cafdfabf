// tetrec-optimize: fits the radiance field to the images, coarse to fine.
#include "command/help.h"
#include "command/option_checks.h"
#include "command/stage_command.h"
#include "command/word_option.h"
#include "core/stage.h"
#include "optimize/trainer.h"
#include "renderer_options.h"

namespace {

void AddOptions(tetrec::StageCommand& command, tetrec::OptimizeOptions& options) {
  CLI::App& app = command.app();
  app.add_option("--time-limit", options.time_limit_s,
                 "Seconds of optimisation, refinement included; 0: limited by --iterations, or, if "
                 "that is 0, too, the run ends once the judging pictures gain no more");
  app.add_option("--iterations", options.iterations, "Training steps; 0: no limit");
  app.add_option("--seed", options.seed, "Random seed");
  app.add_option(
      "--rays", options.rays_per_step,
      "Rays per step (default 4096; on a GPU 65536, or 16384 if its memory is the host's)");
  tetrec::AddParsedOption(
      app, "--loss", options.loss, tetrec::ParseLoss, Name(options.loss),
      "Loss: l2 (highest PSNR), l1 (sharper, robust to outliers), or either with a share of "
      "D-SSIM, (1 - SSIM) / 2: l1+dssim:0.2 is 0.8 l1 + 0.2 D-SSIM");
  tetrec::AddWordOption(app, "--storage", options.storage,
                        "Where density and colour are stored: vertex (linear inside each tet) or "
                        "cell (constant inside "
                        "each tet)");
  app.add_option("--color-rate", options.color_rate,
                 "Initial learning rate of colour [display sRGB] (default 0.02 for images with "
                 "alpha, 0.012 for others)")
      ->check(tetrec::AboveZero());
  app.add_option("--sh-rate", options.harmonics_rate,
                 "Initial learning rate of the coefficients of harmonics [display sRGB] (default "
                 "0.015 for images with alpha, 0.009 for others)")
      ->check(tetrec::AboveZero());
  app.add_option(
         "--sh-decay", options.harmonics_decay,
         "Decay of the coefficients of harmonics at visible vertices: the share that each step "
         "removes, per unit of their learning rate")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--density-rate", options.density_rate,
                 "Initial learning rate of density's parameter: its logarithm, of signed density "
                 "asinh(value / scale), of softplus density ln(e^(value / scale) - 1) (default 0.2 "
                 "for images with alpha, 0.12 for others)")
      ->check(tetrec::AboveZero());
  app.add_option("--position-rate", options.position_rate,
                 "Initial learning rate of positions: as a share of the edges of a vertex (default "
                 "0.1) or, with --move article, of the subject's longest side (default 2e-5)")
      ->check(tetrec::AboveZero());
  app.add_option("--quality-weight", options.quality.strength,
                 "Weight of the regulariser that keeps moving vertices from flattening tets "
                 "(lambda of the DiffTetVR article); 0: none")
      ->check(tetrec::AtLeastZero());
  app.add_option("--quality-sharpness", options.quality.sharpness,
                 "Sharpness of that regulariser (beta of the article): large values affect only "
                 "the flattest tets")
      ->check(tetrec::AboveZero());
  app.add_option(
         "--final-rate-share", options.schedule.final_rate_share,
         "Share to which learning rates fall exponentially; by default they fall slowly at first, "
         "fast in the last quarter, and further in longer runs, by half around the 120th second")
      ->check(CLI::Range(1e-6, 1.0));
  tetrec::AddWordOption(
      app, "--density", options.density,
      "Values of density: signed (surfaces lie anywhere inside a tet, where the value changes its "
      "sign), positive (its logarithm is learned), softplus (positive; dense vertices change by "
      "equal steps instead of by equal shares), or auto (signed for pictures with alpha, positive "
      "for photos)");
  app.add_option("--max-density", options.max_density, "Upper bound of density [1 / world unit]");
  app.add_option("--density-decay", options.density_decay,
                 "Pull of visible vertices towards empty, as a share of Adam's largest step; by "
                 "default 0.05 for photos and 0 for pictures with alpha. Surfaces that many photos "
                 "see are not pulled")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--jitter", options.jitter_px,
                 "Random offset of rays, as a part of their share of a pixel: 0 (always at its "
                 "centre) to 1 (anywhere in it), or more")
      ->check(CLI::Range(0.0, 2.0));
  app.add_option("--subject-share", options.subject_share,
                 "Share of the rays drawn from pixels that show the subject")
      ->check(CLI::Range(0.0, 1.0));
  tetrec::AddWordOption(
      app, "--background", options.background,
      "What is behind the field and its training images: random (another colour in each step, "
      "which distinguishes empty from background-coloured), scene (as imported), or auto (scene, "
      "and opacity is learned from alpha; random for images without alpha)");
  tetrec::AddWordOption(
      app, "--camera-space", options.camera_space,
      "Where the cameras of photos stand and move: empty (no density) or learned");
  tetrec::AddWordOption(app, "--seen-space", options.seen_space,
                        "Space in front of the surfaces in the depth maps, where at most 12 photos "
                        "look: empty (no density) or learned");
  tetrec::AddWordOption(
      app, "--seen-surfaces", options.seen_surfaces,
      "Surfaces on which the depth maps of several photos agree: kept (they never "
      "become transparent) or learned");
  tetrec::AddWordOption(app, "--judging-pictures", options.judging_pictures,
                        "Parts of the training pictures: kept back in the first part of a run, to "
                        "judge refinements, or learned throughout, while nothing judges");
  tetrec::AddWordOption(app, "--exposure", options.exposure,
                        "Estimation of exposure and white balance of each photo: auto (for photos "
                        "without alpha), on or off");
  tetrec::AddWordOption(app, "--poses", options.poses,
                        "Small corrections of the training cameras, kept if the judging pictures "
                        "gain by them: auto (where cameras were estimated from photos), on or off");
  tetrec::AddWordOption(app, "--stray-photos", options.stray_photos,
                        "Photos that do not fit the others, because their cameras are wrong or "
                        "something has moved: auto (left out if the others gain by it) or learned");
  tetrec::AddWordOption(
      app, "--move", options.move,
      "How vertices move: safe (no tet turns inside out), article (by Adam on each coordinate in "
      "every second epoch, as in the DiffTetVR article; may break the mesh) or off");
  tetrec::AddWordOption(
      app, "--sh", options.harmonics,
      "Degree of spherical harmonics by which colours depend on the view: 0 (they do not) to 3, or "
      "auto (1 and 2 if the judging pictures gain, then 3; no more than the photos determine)");
  tetrec::AddWordOption(
      app, "--fine-rays", options.fine_rays,
      "2 x 2 rays per pixel, whose mean is compared with the photo, in the last quarter of a run "
      "of up to 120 s, or from the 90th second of a longer one: auto (for images with alpha, as "
      "a trial decides; otherwise one ray), on or off");
  app.add_option(
         "--rounds", options.schedule.rounds,
         "Refinements of the mesh; by default 3 to 9, by how much it may grow, and further ones in "
         "runs of more than 120 s")
      ->check(CLI::Range(0, 100));
  app.add_option("--last-round", options.schedule.last_round,
                 "Share of the run before the last refinement")
      ->check(CLI::Range(0.01, 0.99));
  tetrec::AddWordOption(
      app, "--budget", options.budget,
      "Size of the mesh: auto (what the time affords, and no more once the judging pictures gain "
      "nothing by it) or full (up to --budget-tets, --budget-mb or --max-vertices)");
  app.add_option(
         "--matched-psnr", options.schedule.matched_psnr,
         "PSNR of the judging pictures, less its standard error, from which the mesh grows no "
         "more, and becomes as coarse as it can be without falling below it [dB]")
      ->check(CLI::Range(10.0, 1000.0));
  app.add_option("--budget-tets", options.budget_tets,
                 "Number of tets that the mesh never exceeds; 0: no such bound");
  app.add_option("--budget-mb", options.budget_mb,
                 "Peak of resident memory that the mesh keeps to, by a prediction [MB = 10^6 "
                 "bytes]; 0: no such bound");
  app.add_option("--max-vertices", options.max_vertices,
                 "Largest number of vertices after refinement; 0: what the time allows");
  tetrec::AddWordOption(
      app, "--refine", options.refine,
      "Refinement of the mesh: insert (new vertices on the longest edges of the worst tets; "
      "vertices that the pictures do not need are dropped; triangulated anew, except in the late "
      "rounds of a long run, which work as halve does), halve (in place: the worst edges are "
      "halved, and vertices that the pictures do not need are moved onto neighbours), bisect (the "
      "worst tets halved at their longest edges) or "
      "prism (the DiffTetVR article's: all edges at the worst vertices halved)");
  tetrec::AddWordOption(
      app, "--score", options.score,
      "What is worst: residual (squared errors), color or position (absolute gradients by colours "
      "or by positions), variance (of the squared errors over the views), gain (predicted loss of "
      "squared error by a vertex in the middle of an edge), or auto (color with --refine prism, "
      "else residual)");
  tetrec::AddWordOption(
      app, "--prism-diagonals", options.prism_diagonals,
      "How --refine prism cuts the sides of prisms: shorter (diagonal) or flips (the search of "
      "Erleben et al., as in the article)");
  app.add_option("--split-share", options.split_share,
                 "Largest share of the vertices that one round of --refine prism splits")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option(
         "--score-rays", options.score_rays_per_tet,
         "Rays per tet that gather the errors for a refinement; at least 1 for squared errors")
      ->check(tetrec::AboveZero());
  app.add_option(
         "--watched-views", options.watched_views,
         "Held-out views whose PSNR is recorded in metrics.csv: during the run that of up to "
         "40,000 of their pixels, at the end that of all")
      ->check(CLI::Range(0, 1000));
  app.add_flag("--deterministic", options.renderer.deterministic,
               "Give the same bytes for any number of threads and after a resume, a little slower; "
               "requires --time-limit 0");
  command.DoesNotChangeResults(app.add_option("--checkpoint-interval",
                                              options.checkpoint_interval_s,
                                              "Seconds between checkpoints")
                                   ->check(tetrec::AtLeastZero()));
  using tetrec::GroupOptions;
  GroupOptions(
      app, "Length of the run",
      {"--time-limit", "--iterations", "--seed", "--deterministic", "--checkpoint-interval"});
  GroupOptions(app, "Rays and loss",
               {"--rays", "--loss", "--jitter", "--subject-share", "--background", "--fine-rays",
                "--judging-pictures", "--watched-views"});
  GroupOptions(app, "Field",
               {"--storage", "--density", "--max-density", "--density-decay", "--sh", "--sh-decay",
                "--camera-space", "--seen-space", "--seen-surfaces"});
  GroupOptions(
      app, "Learning rates",
      {"--color-rate", "--sh-rate", "--density-rate", "--position-rate", "--final-rate-share"});
  GroupOptions(app, "Photos and cameras", {"--exposure", "--poses", "--stray-photos"});
  GroupOptions(app, "Mesh",
               {"--move", "--quality-weight", "--quality-sharpness", "--rounds", "--last-round",
                "--budget", "--matched-psnr", "--budget-tets", "--budget-mb", "--max-vertices",
                "--refine", "--score", "--prism-diagonals", "--split-share", "--score-rays"});
  AddRendererOptions(command, options.renderer);
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::OptimizeOptions options;
  tetrec::StageCommand command(
      "optimize", 32,
      "Fits density and colour on a tet mesh to the images of its scene, and refines the mesh.\n"
      "Example: tetrec-optimize RUN/2_tetrahedra -o RUN/3_field");
  command.InputStage("TETRAHEDRA", "Folder that tetrec-tetrahedralize wrote", {"tetrahedralize"});
  AddOptions(command, options);
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunOptimize(options, stage); },
      [&] {
        const CLI::App& app = command.app();
        if (options.harmonics == tetrec::HarmonicsChoice::kNone) {
          tetrec::RefuseOptions(app, {"--sh-rate", "--sh-decay"},
                                "has no effect with --sh 0; leave it out");
        }
        if (options.budget == tetrec::BudgetChoice::kFull) {
          tetrec::RefuseOptions(app, {"--matched-psnr"},
                                "has no effect with --budget full; leave it out");
        }
        options.renderer.Check();
        options.Check();
      });
}
