// The options of the optimize stage.
#pragma once

#include "field/layout.h"
#include "mesh/tet_quality.h"
#include "optimize/camera_poses.h"
#include "optimize/density_form.h"
#include "optimize/exposure.h"
#include "optimize/harmonics.h"
#include "optimize/schedule.h"
#include "refine/refine.h"
#include "render/loss.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <optional>

namespace tetrec {

// What is in space that should be empty: where the cameras stand and move (camera_space.h), and
// what a few photos see to be empty (photo_sight.h).
enum class SpaceContent {
  kEmpty,    // no density
  kLearned,  // what the photos ask for
};
template <>
inline constexpr auto kWords<SpaceContent> = std::to_array<Word<SpaceContent>>(
    {{SpaceContent::kEmpty, "empty"}, {SpaceContent::kLearned, "learned"}});

// What becomes of surfaces on which the depth maps of several photos agree (photo_sight.h).
enum class SurfaceContent {
  kKept,     // they never become transparent
  kLearned,  // what the photos ask for
};
template <>
inline constexpr auto kWords<SurfaceContent> = std::to_array<Word<SurfaceContent>>(
    {{SurfaceContent::kKept, "kept"}, {SurfaceContent::kLearned, "learned"}});

// What becomes of parts of the training pictures (judging.h).
enum class JudgingPictures {
  kKept,     // for a while from learning; they judge refinements
  kLearned,  // like all others; nothing judges
};
template <>
inline constexpr auto kWords<JudgingPictures> = std::to_array<Word<JudgingPictures>>(
    {{JudgingPictures::kKept, "kept"}, {JudgingPictures::kLearned, "learned"}});

// What becomes of photos that do not fit the others (stray_photos.h).
enum class StrayChoice {
  kAuto,     // left out if the judging pictures of the others gain by it
  kLearned,  // like all others
};
template <>
inline constexpr auto kWords<StrayChoice> = std::to_array<Word<StrayChoice>>(
    {{StrayChoice::kAuto, "auto"}, {StrayChoice::kLearned, "learned"}});

// Rays per pixel once a run has grown (fine_rays.h).
enum class FineRaysChoice {
  kAuto,  // for pictures with alpha, 2 x 2 unless they clearly lose in a trial; otherwise one
  kOn,    // 2 x 2
  kOff,   // one
};
template <>
inline constexpr auto kWords<FineRaysChoice> = std::to_array<Word<FineRaysChoice>>(
    {{FineRaysChoice::kAuto, "auto"}, {FineRaysChoice::kOn, "on"}, {FineRaysChoice::kOff, "off"}});

// How vertices move.
enum class MoveChoice {
  kSafe,     // no farther than the tets allow (vertex_motion.h)
  kArticle,  // wherever Adam takes each coordinate (article_motion.h)
  kOff,
};
template <>
inline constexpr auto kWords<MoveChoice> = std::to_array<Word<MoveChoice>>(
    {{MoveChoice::kSafe, "safe"}, {MoveChoice::kArticle, "article"}, {MoveChoice::kOff, "off"}});

// By what a refinement chooses where it refines (refine_scores.h).
enum class RefineScore {
  kAuto,      // kColor for the scheme prism, kResidual for the others
  kResidual,  // squared residuals, by the share that a tet has in what the rays show
  kColor,     // absolute gradients by a vertex's colour, summed over rays
  kPosition,  // absolute gradients by a vertex's position across the rays, summed over rays (AbsGS)
  kVariance,  // variance over the views of what kResidual sums
  kGain,      // what the squared error would lose by a vertex in the middle of an edge
};
template <>
inline constexpr auto kWords<RefineScore> =
    std::to_array<Word<RefineScore>>({{RefineScore::kAuto, "auto"},
                                      {RefineScore::kResidual, "residual"},
                                      {RefineScore::kColor, "color"},
                                      {RefineScore::kPosition, "position"},
                                      {RefineScore::kVariance, "variance"},
                                      {RefineScore::kGain, "gain"}});

// What is behind the field and its training pictures. Another colour in each step distinguishes
// what is empty from what has the colour of the background, but adds noise. Where pictures have
// alpha, a loss of opacity does so without noise.
enum class BackgroundChoice {
  kAuto,    // the scene's own, and opacity is learned from alpha; random for photos
  kRandom,  // another colour in each step
  kScene,   // the scene's own
};
template <>
inline constexpr auto kWords<BackgroundChoice> =
    std::to_array<Word<BackgroundChoice>>({{BackgroundChoice::kAuto, "auto"},
                                           {BackgroundChoice::kRandom, "random"},
                                           {BackgroundChoice::kScene, "scene"}});

// How the size of the mesh is chosen, up to any bound that is given.
enum class BudgetChoice {
  kAuto,  // as the time affords; growth ends once the judging pictures gain no more by it
  kFull,  // up to the bound, whatever is gained
};
template <>
inline constexpr auto kWords<BudgetChoice> = std::to_array<Word<BudgetChoice>>(
    {{BudgetChoice::kAuto, "auto"}, {BudgetChoice::kFull, "full"}});

// What a trial has decided. Checkpoints contain the numbers.
enum class TrialState : uint32_t { kNotTried, kNotUsed, kUsed };

struct OptimizeOptions {
  double time_limit_s = 300;  // of optimisation, with refinement and watching; 0: none
  uint64_t iterations = 0;    // 0: no limit; without any the run ends by itself (convergence.h)
  uint64_t seed = 1;
  std::optional<int> rays_per_step;  // by default those of RaysPerStep
  LossOptions loss;
  // Adam's first steps on colour [display sRGB], on density's parameter, and on coefficients
  // [display sRGB]. By default FirstRatesOf.
  std::optional<double> color_rate, density_rate, harmonics_rate;
  // A vertex's first moves: as a share of its edges' mean length or, with kArticle, Adam's step as
  // a share of the subject's longest side. By default PositionRateOf.
  std::optional<double> position_rate;
  // Added to the loss while vertices move; none by default, because moves are safe without it.
  QualityRegulariser quality{.strength = 0, .sharpness = 100};
  // Pull of coefficients towards 0 (AdamUpdate). What they add for views from where no photo was
  // taken is a guess, and a small one errs less.
  double harmonics_decay = 0.3;
  double max_density = AdamUpdate().max_density;  // [1 / world unit]
  // Pull of seen vertices towards empty, as a share of Adam's largest step; surfaces that many
  // photos see are not pulled (FittedField). By default DensityDecay.
  std::optional<double> density_decay;
  // Rays are moved inside their share of the pixel by up to half of this part of it: more blurs.
  double jitter_px = 0.0;
  double subject_share = 0.85;  // share of the rays drawn where the masks show something
  BackgroundChoice background = BackgroundChoice::kAuto;  // behind field and target
  ExposureMode exposure = ExposureMode::kAuto;            // of the training photos
  PoseMode poses = PoseMode::kAuto;                       // corrections of the training cameras
  StrayChoice stray_photos = StrayChoice::kAuto;
  HarmonicsChoice harmonics = HarmonicsChoice::kAuto;
  FineRaysChoice fine_rays = FineRaysChoice::kAuto;
  MoveChoice move = MoveChoice::kSafe;
  BudgetChoice budget = BudgetChoice::kAuto;
  uint64_t budget_tets = 0;   // bound on tets; 0: none
  uint64_t budget_mb = 0;     // bound on the predicted peak of memory [10^6 bytes]; 0: none
  uint64_t max_vertices = 0;  // 0: as many as the time affords
  RefineScheme refine = RefineScheme::kInsert;
  PrismDiagonals prism_diagonals = PrismDiagonals::kShorter;
  double split_share = 1.0;  // RefineOptions::split_share
  RefineScore score = RefineScore::kAuto;
  double score_rays_per_tet = 1;  // by which a refinement judges the tets
  int watched_views = 4;          // held-out views whose PSNR goes into metrics.csv
  double checkpoint_interval_s = 30;
  SpaceContent camera_space = SpaceContent::kEmpty;
  SpaceContent seen_space = SpaceContent::kEmpty;
  SurfaceContent seen_surfaces = SurfaceContent::kKept;
  JudgingPictures judging_pictures = JudgingPictures::kKept;
  FieldStorage storage = FieldStorage::kVertex;  // of the fitted field
  DensityForm density = DensityForm::kAuto;
  ScheduleOptions schedule;
  RendererOptions renderer;

  // Fixed-point sums have less room for the digits of each ray, the more rays a step has; so
  // deterministic steps are small on every device.
  int RaysPerStep(const DevicePace& pace) const {
    return rays_per_step.value_or(renderer.deterministic ? DevicePace().rays_per_step
                                                         : pace.rays_per_step);
  }
  bool HasLimit() const { return time_limit_s > 0 || iterations > 0; }
  void Check() const;  // throws UsageError naming the option and its value
};

// The score that a run uses, never kAuto.
RefineScore ScoreOf(const OptimizeOptions& options);
struct FirstRates {
  double color, density, harmonics;
};
// Photos learn more slowly than pictures with alpha (measured: tests/bench/schedule.md).
FirstRates FirstRatesOf(const OptimizeOptions& options, bool has_alpha);
// The first rate of positions: 0.1 of the edges, or the article's 1e-5 in a box of 0.5.
double PositionRateOf(const OptimizeOptions& options);
// Photos differ in exposure, which fog in front of their cameras explains unless density decays.
// Pictures with alpha do not, and show what is empty.
inline double DensityDecay(bool has_alpha) { return has_alpha ? 0.0 : 0.05; }

}  // namespace tetrec
