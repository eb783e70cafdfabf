// The optimisation of a radiance field against the pictures of a scene.
#include "optimize/trainer.h"

#include "core/error.h"
#include "core/error_context.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "field/change_storage.h"
#include "optimize/batches.h"
#include "optimize/checkpoint.h"
#include "optimize/coarsening.h"
#include "optimize/convergence.h"
#include "optimize/error_look.h"
#include "optimize/exposure.h"
#include "optimize/fine_rays.h"
#include "optimize/fitted_field.h"
#include "optimize/harmonics_trials.h"
#include "optimize/mesh_budget.h"
#include "optimize/photo_sight.h"
#include "optimize/pose_sweeps.h"
#include "optimize/rate_trial.h"
#include "optimize/refinement_rounds.h"
#include "optimize/run_counts.h"
#include "optimize/run_length.h"
#include "optimize/run_outputs.h"
#include "optimize/stray_photos.h"
#include "optimize/training_history.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"
#include "optimize/vertex_motion.h"
#include "optimize/watch.h"
#include "optimize/weak_colors.h"
#include "render/create_renderer.h"
#include "render/kernel_table.h"
#include "render/picture.h"
#include "render/seen_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

RendererOptions RendererOptionsOf(const OptimizeOptions& options) {
  RendererOptions renderer = options.renderer;
  if (options.move == MoveChoice::kArticle) renderer.AcceptInvertedTets();
  return renderer;
}

bool CamerasWereEstimated(const fs::path& scene_folder) {
  return ReadManifestOrStatus(scene_folder / kManifestFile)["stage"] == "sfm";
}

class Trainer {
 public:
  Trainer(const OptimizeOptions& options, const fs::path& scene_folder, const Scene& scene,
          TrainingSet set, PhotoSight sight, const TetMesh& start, Stage& stage)
      : options_(options),
        scene_folder_(scene_folder),
        scene_(scene),
        stage_(stage),
        affording_pixels_(AffordingPixels(set, start)),
        max_tets_(TetBudget(options, set, start.tets.size())),
        renderer_(CreateRenderer(RendererOptionsOf(options))),
        length_(LengthOf(options, renderer_->Pace(), affording_pixels_, max_tets_)),
        max_vertices_(MaxVertices(options, length_, affording_pixels_, max_tets_)),
        watched_{*renderer_, scene_folder_, scene,
                 ChooseWatchedViews(scene, options.watched_views)},
        pictures_(options, std::move(set), BackgroundColor(scene.background), *renderer_),
        batches_(options, pictures_.set(), *renderer_, pictures_.background_srgb(), scene_folder),
        field_(options, scene, *renderer_, batches_, std::move(sight), DensityOfSurfaces(start)),
        motion_(options, field_, *renderer_, pictures_.set().views.size()),
        steps_(options, scene.has_alpha, batches_, *renderer_, motion_),
        rate_trial_(options, field_, pictures_, steps_),
        poses_(options, pictures_, *renderer_),
        stray_(options, field_, pictures_, steps_),
        harmonics_(options, field_, pictures_, steps_),
        fine_rays_(options, scene.has_alpha, field_, pictures_, steps_),
        rounds_(
            options,
            PlanRounds(options, length_, start.positions.size(), max_vertices_, affording_pixels_),
            {field_, motion_, pictures_, batches_, steps_, *renderer_},
            {stage.Scratch("best.bin"), stage.Scratch("unrefined.bin"),
             stage.Scratch("coarser.bin"), stage.Scratch("finer.bin")},
            max_tets_),
        coarsening_(options, {field_, motion_, pictures_, batches_, steps_, *renderer_}, rounds_,
                    stage.Scratch("finer.bin"), stage.Scratch("coarser.bin")),
        checkpoint_path_(stage.Scratch(kCheckpointFile)) {}

  // Nothing of the start is left once the run has begun: it would be in memory to the end.
  RadianceField Run(RadianceField start) {
    Introduce(start.mesh);
    Begin(std::move(start));
    TrainingHistory history(stage_.Output(kTrainingLogFile), metrics_bytes_, watched_,
                            options_.HasLimit(), DegenerateCounter());
    Train(history);
    if (StopRequested()) {
      SaveCheckpoint(history.bytes());
      throw Interrupted(fmt::format(
          "stopped at iteration {} after {:.0f} s; the same command continues from here",
          steps_.iteration(), seconds_));
    }
    if (ColorsMayHaveDrifted()) SettleWeakColors();
    Report(history.End(Figures(Done())));
    end_of_growth_ = StepOf(seconds_, steps_.iteration(), field_.mesh());
    end_of_growth_.decision = GrowthDecision::kEnd;
    CountEmptyTets();
    const FieldState state = field_.ReadState();
    return FieldOf(field_.TakeMesh(), state);
  }

  void WriteEstimates() {
    std::vector<GrowthStep> growth = rounds_.state().steps;
    growth.push_back(end_of_growth_);
    WriteMeshGrowth(stage_.Output(kMeshGrowthFile), growth);
    const std::vector<uint8_t>& left_out = stray_.state().left_out;
    WriteExposures(scene_, exposure_.State(*renderer_).exposures, left_out, stage_);
    WriteCorrections(scene_, pictures_.given_views(), poses_.state().poses, left_out, stage_);
    WriteLeftOut(scene_, left_out, stage_);
  }

 private:
  void Introduce(const TetMesh& start) {
    stage_.Device(renderer_->DescribeDevice());
    LogInfo("{} training views, {} pixels; device {}; steps of {} rays; up to {} vertices",
            pictures_.set().views.size(), WithThousands(pictures_.set().pixels),
            renderer_->DescribeDevice()["name"].get<std::string>(),
            WithThousands(batches_.rays_per_step()), WithThousands(max_vertices_));
    stage_.Count("rays_per_step", uint64_t(batches_.rays_per_step()));
    const uint32_t degree = HighestDegree(options_.harmonics, pictures_.set().views.size());
    if (options_.harmonics == HarmonicsChoice::kAuto && degree < kMostHarmonicsDegree) {
      LogInfo("harmonics of degree {} or more are left out: they need {} training photos",
              degree + 1, PhotosForDegree(degree + 1));
    }
    if (max_tets_ != kNoBudget) {
      LogInfo("the budget allows {} tets; predicted peak of memory {:.0f} MB",
              WithThousands(max_tets_),
              PredictedPeakBytes(degree, double(max_tets_), pictures_.set().pixels) / 1e6);
    }
    if (options_.max_vertices > 0 && options_.max_vertices < start.positions.size()) {
      LogWarning(
          "at most {} vertices are allowed, but the mesh starts with {}: it does not grow; allow "
          "more, or start coarser (see tetrec-tetrahedralize)",
          options_.max_vertices, start.positions.size());
    }
  }

  void Begin(RadianceField start) {
    if (!options_.HasLimit() && !pictures_.can_judge()) {
      throw DataError(fmt::format(
          "{}: its pictures are too small for parts that judge, so nothing would end the run: set "
          "--time-limit or --iterations",
          scene_folder_.string()));
    }
    if (stage_.resume() && fs::exists(checkpoint_path_)) {
      Resume(ReadCheckpoint(checkpoint_path_));
    } else {
      if (stage_.resume()) LogInfo("no checkpoint was saved: starts at the first iteration");
      if (EstimatesExposure()) exposure_ = ExposureEstimate(pictures_.set().views.size());
      poses_.Start(CamerasWereEstimated(scene_folder_), Done());
      RadianceField stored = WithStorage(std::move(start), options_.storage);
      const Attribute density = LearnedDensity(options_.density, scene_.has_alpha, stored);
      FieldState state = WithHarmonics(StateOf(stored, density), 0);
      field_.Put(std::move(stored.mesh), std::move(state));
    }
    if (exposure_.is_on()) renderer_->SetExposures(exposure_.State(*renderer_).exposures);
  }

  void Resume(Checkpoint checkpoint) {
    const std::string name = checkpoint_path_.string();
    if (checkpoint.state.layout.storage != options_.storage) {
      throw DataError(
          fmt::format("{}: contains a field with one row per {}, not per {}; force a fresh run",
                      name, RowName(checkpoint.state.layout.storage), RowName(options_.storage)));
    }
    if (checkpoint.pace != renderer_->Pace()) {
      throw DataError(
          fmt::format("{}: was written on another kind of device, whose steps have {} rays, "
                      "not {}; choose that device, or force a fresh run",
                      name, checkpoint.pace.rays_per_step, renderer_->Pace().rays_per_step));
    }
    seconds_ = checkpoint.seconds;
    metrics_bytes_ = checkpoint.metrics_bytes;
    steps_.Resume(checkpoint.iteration, checkpoint.rays);
    steps_.UseShareOfRates(checkpoint.share_of_rates);
    rounds_.Resume(std::move(checkpoint.rounds));
    coarsening_.Resume(std::move(checkpoint.coarsening));
    convergence_.Resume(checkpoint.convergence);
    harmonics_.Resume(checkpoint.harmonics);
    fine_rays_.Resume(checkpoint.fine_rays);
    exposure_ = ResumedExposure(std::move(checkpoint.exposure));
    stray_.Resume(std::move(checkpoint.stray), name);
    poses_.Resume(std::move(checkpoint.poses), name, Done());
    field_.Resume(std::move(checkpoint.mesh), checkpoint.state, std::move(checkpoint.row_rates));
    motion_.Resume(std::move(checkpoint.motion));
    LogInfo("continues from iteration {} after {:.0f} s", steps_.iteration(), seconds_);
  }

  // Until the run is done, or asked to stop.
  void Train(TrainingHistory& history) {
    const Timer timer;
    const double seconds_before = seconds_;
    double last_checkpoint = seconds_;
    while (true) {
      seconds_ = seconds_before + timer.seconds();
      const double done = Done();
      if (done >= 1.0) return;
      // What a stop takes back must be the state of a run that can be resumed.
      const bool can_resume = motion_.CanResumeAfter(steps_.iteration(), done);
      if (can_resume) {
        if (StopRequested()) return;
        if (seconds_ - last_checkpoint >= options_.checkpoint_interval_s) {
          last_checkpoint = seconds_;
          SaveCheckpoint(history.bytes());
        }
      }
      if (rate_trial_.Advance()) continue;
      if (!options_.HasLimit() && convergence_.IsDue(steps_.iteration())) {
        LookForConvergence();
        continue;
      }
      const double growth = Growth();
      motion_.StartIfDue(growth);
      if (rounds_.IsDue(growth) && (!rounds_.NeedsTrial() || can_resume)) {
        rounds_.Advance(seconds_, {done, growth});
        continue;
      }
      if (can_resume && coarsening_.IsDue(done)) {
        coarsening_.Advance(seconds_, {done, growth});
        continue;
      }
      if (can_resume && harmonics_.Advance(growth)) continue;
      if (can_resume && fine_rays_.Advance(growth)) {
        if (fine_rays_.state() == TrialState::kUsed) JudgeAnew();
        continue;
      }
      // A trial was stopped: the resumed run repeats it.
      if (can_resume && StopRequested()) continue;
      if (poses_.IsDue({done, growth})) CorrectPoses(done);
      if (can_resume && stray_.IsDue(growth)) {
        if (stray_.Advance()) JudgeAnew();
        continue;
      }
      // After all trials that are due, which may be late because others took long.
      pictures_.EndJudgingIfDue(done);
      history.Add(TakeStep({done, growth}));
      history.Record(Figures(done));
    }
  }

  bool EstimatesExposure() const {
    if (options_.exposure == ExposureMode::kAuto) return !scene_.has_alpha;
    return options_.exposure == ExposureMode::kOn;
  }

  ExposureEstimate ResumedExposure(ExposureState state) const {
    const size_t views = pictures_.set().views.size();
    const size_t expected = EstimatesExposure() && views > 1 ? views : 0;
    if (state.exposures.size() != expected) {
      throw DataError(
          fmt::format("{}: contains the exposures of {} photos, not {}; force a fresh run",
                      checkpoint_path_.string(), state.exposures.size(), expected));
    }
    return ExposureEstimate(std::move(state));
  }

  // The progress of the run, in [0, 1].
  double Done() const {
    if (!options_.HasLimit()) return convergence_.Progress(steps_.iteration());
    return ProgressOf(SecondsOfSteps(), double(options_.iterations));
  }

  // Until the limit, or until the look at weak colours must begin. Time for it is set aside little
  // by little, so that progress does not jump, and all of it before the look is worth while.
  // 0: there is no limit.
  double SecondsOfSteps() const {
    if (!SettlesColors()) return options_.time_limit_s;
    const double aside = std::clamp(4 * Passes() / kPassesOfDrift - 3, 0.0, 1.0);
    return options_.time_limit_s * (1 - aside / std::max(Passes(), 1.0));
  }

  // Measured on photos only: alpha shows what is empty.
  bool SettlesColors() const {
    return !scene_.has_alpha && options_.storage == FieldStorage::kVertex && !batches_.DrawsTiles();
  }

  bool ColorsMayHaveDrifted() const { return SettlesColors() && Passes() >= kPassesOfDrift; }

  // Rays per learned pixel, those of trials included.
  double Passes() const { return double(steps_.rays()) / double(LearnedPixels(pictures_.set())); }

  void SettleWeakColors() {
    const Timer timer;
    const std::vector<float> evidence =
        LookAtColorEvidence(*renderer_, pictures_.set(), batches_, options_.seed);
    FieldState state = field_.ReadState();
    SmoothWeakColors(field_.mesh(), evidence, state);
    field_.PutState(std::move(state));
    seconds_ += timer.seconds();
    const auto weak = std::ranges::count_if(evidence, [](float e) { return e < kPriorEvidence; });
    stage_.Count("weak_colors", uint64_t(weak));
    LogInfo(
        "{} vertices, whose colours hardly any ray determines, follow their neighbours; {:.1f} s",
        WithThousands(uint64_t(weak)), timer.seconds());
  }

  // The growth of the run (schedule.h).
  double Growth() const {
    if (!options_.HasLimit()) return ProgressOf(0, kGrowthSteps);
    return ProgressOf(std::min(options_.time_limit_s, kGrowthSeconds),
                      std::min(double(options_.iterations), kGrowthSteps));
  }

  // The progress of a run with these limits, of which 0 is none.
  double ProgressOf(double time_limit_s, double iterations) const {
    double progress = 0;
    if (time_limit_s > 0) progress = seconds_ / time_limit_s;
    if (iterations > 0) progress = std::max(progress, double(steps_.iteration()) / iterations);
    return progress;
  }

  void LookForConvergence() {
    const double psnr = pictures_.JudgeField().psnr;
    convergence_.Look(steps_.iteration(), psnr, rounds_.IsOver() && coarsening_.IsOver());
    const ConvergenceState& state = convergence_.state();
    LogInfo("judging pictures after {} steps: {:.2f} dB, at their best {:.2f}{}",
            WithThousands(steps_.iteration()), psnr, state.best_psnr,
            state.converged > 0 ? ": the run ends after a last part" : "");
  }

  void CorrectPoses(double done) {
    // The best field, or one before it, is judged with these cameras from now on.
    rounds_.RaiseBest(poses_.Sweep(exposure_.State(*renderer_).exposures, done));
  }

  // Judges the fields to compare with once more, after a change of the pixels that judge.
  void JudgeAnew() {
    rounds_.JudgeAnew(pictures_.JudgeField());
    coarsening_.JudgeAnew();
  }

  StepResult TakeStep(const RunMoment& moment) {
    const StepResult result = steps_.Take(moment, exposure_.Gathers(moment.growth));
    if (exposure_.IsFitDue(steps_.iteration(), moment.growth)) {
      pictures_.GatherExposuresOfWholeViews(steps_.iteration());
      exposure_.Fit(*renderer_);
    }
    return result;
  }

  // Safe moves leave no degenerate tet.
  std::function<uint64_t()> DegenerateCounter() const {
    if (options_.move != MoveChoice::kArticle) return {};
    return [this] { return CountDegenerateTets(field_.mesh()); };
  }

  RunFigures Figures(double done) const {
    const TetMesh& mesh = field_.mesh();
    return {done,          seconds_,         steps_.iteration(),
            steps_.rays(), mesh.tets.size(), mesh.positions.size()};
  }

  void SaveCheckpoint(uint64_t metrics_bytes) {
    Checkpoint checkpoint;
    checkpoint.iteration = steps_.iteration();
    checkpoint.seconds = seconds_;
    checkpoint.rays = steps_.rays();
    checkpoint.pace = renderer_->Pace();
    checkpoint.share_of_rates = steps_.share_of_rates();
    checkpoint.rounds = rounds_.state();
    checkpoint.coarsening = coarsening_.state();
    checkpoint.convergence = convergence_.state();
    checkpoint.metrics_bytes = metrics_bytes;
    checkpoint.harmonics = harmonics_.state();
    checkpoint.fine_rays = fine_rays_.state();
    checkpoint.motion = motion_.state();
    checkpoint.mesh = field_.mesh();
    checkpoint.state = field_.ReadState();
    checkpoint.row_rates = field_.row_rates();
    checkpoint.exposure = exposure_.State(*renderer_);
    checkpoint.poses = poses_.state();
    checkpoint.stray = stray_.state();
    WriteCheckpoint(checkpoint_path_, checkpoint);
    stage_.KeepSeconds();
  }

  // `psnr`: of the watched views.
  void Report(std::optional<double> psnr) {
    const TetMesh& mesh = field_.mesh();
    stage_.Count("iterations", steps_.iteration());
    stage_.Count("training_rays", steps_.rays());
    stage_.Count("share_of_rates", steps_.share_of_rates());
    stage_.Count("tets", mesh.tets.size());
    stage_.Count("vertices", mesh.positions.size());
    stage_.Count("rounds", rounds_.state().rounds);
    stage_.Count("emptied_rows", field_.emptied_rows());
    stage_.Count("seen_empty_rows", field_.seen_empty_rows());
    stage_.Count("kept_surface_rows", field_.kept_surface_rows());
    stage_.Count("harmonics_degree", field_.harmonics_degree());
    stage_.Count("fine_rays", int(fine_rays_.state() == TrialState::kUsed));
    stage_.Seconds("optimize", seconds_);
    stage_.Count("watched_views", watched_.views.size());
    if (psnr) stage_.Count("watched_psnr", *psnr);
    ReportRays(renderer_->counts(), options_.renderer, stage_);
    ReportMotion(motion_, field_.mesh(), stage_);
    LogInfo(
        "{} iterations, {} rays in {:.1f} s; {} vertices, {} tets{}",
        WithThousands(steps_.iteration()), WithThousands(steps_.rays()), seconds_,
        WithThousands(mesh.positions.size()), WithThousands(mesh.tets.size()),
        psnr ? fmt::format("; {:.2f} dB on {} watched views", *psnr, watched_.views.size()) : "");
    LogKernelTimes(options_.renderer, *renderer_);
  }

  void CountEmptyTets() {
    end_of_growth_.empty_tets = CountEmpty(
        LookAtTets(*renderer_, pictures_.set(), batches_, options_, steps_.iteration()).light);
    stage_.Count("empty_tets", end_of_growth_.empty_tets);
    LogInfo("empty tets, in which no ray loses 1 % of its light: {:.0f} %",
            100.0 * double(end_of_growth_.empty_tets) / double(end_of_growth_.tets));
  }

  const OptimizeOptions& options_;
  fs::path scene_folder_;
  const Scene& scene_;
  Stage& stage_;
  uint64_t affording_pixels_;
  uint64_t max_tets_;
  std::unique_ptr<TrainingRenderer> renderer_;
  RunLength length_;
  uint64_t max_vertices_;
  WatchedViews watched_;
  TrainingPictures pictures_;
  BatchDrawer batches_;
  FittedField field_;
  VertexMotion motion_;
  TrainingSteps steps_;
  RateTrial rate_trial_;
  ExposureEstimate exposure_;
  PoseSweeps poses_;
  StrayPhotos stray_;
  HarmonicsTrials harmonics_;
  FineRays fine_rays_;
  RefinementRounds rounds_;
  Coarsening coarsening_;
  GrowthStep end_of_growth_;
  Convergence convergence_;
  fs::path checkpoint_path_;
  double seconds_ = 0;          // of optimisation
  uint64_t metrics_bytes_ = 0;  // of metrics.csv, at the checkpoint that the run continues from
};

}  // namespace

void RunOptimize(const OptimizeOptions& options, Stage& stage) {
  const fs::path start_folder = stage.Input("TETRAHEDRA");
  const fs::path scene_folder = PreviousStage(start_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const fs::path start_file = start_folder / "field.tetf";
  RadianceField start = ReadField(start_file);
  // Refinement fills it with new tets.
  NamingFile(start_file.string(), [&] { CheckConvexDomain(start.mesh); });
  TrainingSet set = LoadTrainingSet(scene_folder, scene, scene.ViewsOf(Split::kTrain));
  Trainer trainer(options, scene_folder, scene, std::move(set),
                  PhotoSight::Read(scene, start_folder), start.mesh, stage);
  const RadianceField field = trainer.Run(std::move(start));
  trainer.WriteEstimates();
  WriteWorld(scene, scene_folder, stage);
  // Last, because tetrec-view reads the others when it finds a new field.
  WriteField(stage.Output("field.tetf"), field);
}

}  // namespace tetrec
