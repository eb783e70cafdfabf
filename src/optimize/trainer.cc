// The optimisation of a radiance field against the pictures of a scene.
#include "optimize/trainer.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "field/change_storage.h"
#include "geometry/small_motion.h"
#include "optimize/batches.h"
#include "optimize/camera_poses.h"
#include "optimize/camera_space.h"
#include "optimize/checkpoint.h"
#include "optimize/error_look.h"
#include "optimize/exposure.h"
#include "optimize/harmonics.h"
#include "optimize/judging.h"
#include "optimize/refine.h"
#include "optimize/training_set.h"
#include "optimize/watch.h"
#include "render/create_renderer.h"
#include "render/kernel_table.h"
#include "render/picture.h"
#include "render/seen_colors.h"
#include "run/camera_corrections.h"
#include "run/field_world.h"
#include "run/photo_exposures.h"
#include "run/training_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

// Mean losses since the last row of metrics.csv.
struct Averages {
  double loss = 0, squared_error = 0;
  uint64_t count = 0;

  void Add(const StepResult& result) {
    if (result.squared_error == 0 && result.loss == 0) return;  // nothing was collected
    loss += result.loss;
    squared_error += result.squared_error;
    ++count;
  }
  double Loss() const { return count > 0 ? loss / double(count) : 0; }
  double Psnr() const { return count > 0 ? -10 * std::log10(squared_error / double(count)) : 0; }
};

// What the first sweep over the cameras must gain on the judging pictures [dB].
constexpr double kLeastPoseGain_db = 0.03;

bool CamerasWereEstimated(const fs::path& scene_folder) {
  return ReadManifest(scene_folder, {"sfm", "import"})["stage"] == "sfm";
}

class Trainer {
 public:
  Trainer(const OptimizeOptions& options, const fs::path& scene_folder, const Scene& scene,
          Stage& stage)
      : options_(options),
        scene_folder_(scene_folder),
        scene_(scene),
        stage_(stage),
        set_(LoadTrainingSet(scene_folder, scene, scene.ViewsOf(Split::kTrain))),
        given_views_(set_.views),
        watched_(ChooseWatchedViews(scene, options.watched_views)),
        renderer_(CreateRenderer(options.renderer)),
        batches_(options, set_, renderer_->NeedsTiles(), BackgroundColor(scene.background),
                 scene_folder),
        checkpoint_path_(stage.Scratch("checkpoint.bin")),
        best_path_(stage.Scratch("best.bin")) {
    if (options.camera_space == CameraSpace::kEmpty) camera_space_ = FindCameraSpace(scene);
    judging_ = ChooseJudgingSet(set_, options.seed);
    max_vertices_ = options.max_vertices > 0 ? options.max_vertices
                                             : AffordableVertices(ExpectedSeconds(), set_.pixels);
    stage.Device(renderer_->DescribeDevice());
    LogInfo("{} training views, {} pixels; device {}; up to {} vertices", set_.views.size(),
            WithThousands(set_.pixels), renderer_->DescribeDevice()["name"].get<std::string>(),
            WithThousands(max_vertices_));
  }

  RadianceField Run(const RadianceField& start) {
    Begin(start);
    TrainingLogWriter log(stage_.Output(kTrainingLogFile), state_.metrics_bytes);
    Progress progress("optimise", 1.0);
    Timer timer;
    const double seconds_before = state_.seconds;
    double last_row = -1, last_checkpoint = state_.seconds, last_watch = 0;
    Averages averages;
    double watched_psnr = 0;
    bool has_watched = false;
    while (true) {
      state_.seconds = seconds_before + timer.seconds();
      const double done = Done();
      if (done >= 1.0 || StopRequested()) break;
      if (int(state_.rounds) < options_.schedule.rounds &&
          done >= RoundProgress(options_.schedule, int(state_.rounds)) && IsTaught()) {
        RefineOnce();
        continue;
      }
      if (poses_.IsDue(done)) CorrectPoses();
      if (StepHarmonics(done)) continue;
      if (!learns_all_ && !KeepsJudgingPictures(done)) UseTargets(done);
      TrainingBatch batch = batches_.Draw(state_.iteration);
      batch.sums_exposures = exposure_.Gathers(done);
      state_.rays += batch.rays();
      averages.Add(renderer_->Step(batch, NextUpdate(done)));
      exposure_.AfterStep(*renderer_, state_.iteration, done);
      if (done - last_row >= 0.02) {
        last_row = done;
        std::optional<double> psnr;
        if (!watched_.empty() && done - last_watch >= 0.1) {
          last_watch = done;
          watched_psnr = WatchPsnr(*renderer_, scene_folder_, scene_, watched_);
          has_watched = true;
          psnr = watched_psnr;
        }
        log.Add(Row(averages, psnr, "optimise"));
        const double rays_per_s = double(state_.rays) / std::max(state_.seconds, 1e-9);
        progress.Update(
            done, fmt::format("it {}  {:.0f} k rays/s  loss {:.5f}  PSNR {} dB held out"
                              "  {} tets",
                              WithThousands(state_.iteration), rays_per_s / 1000, averages.Loss(),
                              has_watched ? fmt::format("{:.2f}", watched_psnr) : "-",
                              WithThousands(mesh_.tets.size())));
        averages = {};
      }
      if (state_.seconds - last_checkpoint >= options_.checkpoint_interval_s) {
        last_checkpoint = state_.seconds;
        SaveCheckpoint(log.bytes());
      }
    }
    state_.seconds = seconds_before + timer.seconds();
    if (StopRequested()) {
      SaveCheckpoint(log.bytes());
      throw Interrupted(fmt::format(
          "stopped at iteration {} after {:.0f} s; the same command continues from here",
          state_.iteration, state_.seconds));
    }
    const FieldState state = renderer_->ReadState();
    const double psnr =
        watched_.empty() ? 0 : WatchPsnr(*renderer_, scene_folder_, scene_, watched_);
    log.Add(Row(averages, watched_.empty() ? std::nullopt : std::optional(psnr), "end"));
    Report(psnr);
    return FieldOf(mesh_, state);
  }

  // Of the training views; empty if they are not estimated.
  std::vector<PhotoExposure> Exposures() {
    std::vector<PhotoExposure> result;
    const std::vector<int> views = scene_.ViewsOf(Split::kTrain);
    const std::vector<ViewExposure>& exposures = exposure_.State(*renderer_).exposures;
    for (size_t i = 0; i < exposures.size(); ++i) {
      result.push_back(
          {scene_.views[size_t(views[i])].name, exposures[i].gain, exposures[i].offset});
    }
    return result;
  }

  // Of the training views; empty if none were kept.
  std::vector<CameraCorrection> Corrections() const {
    std::vector<CameraCorrection> result;
    const std::vector<int> views = scene_.ViewsOf(Split::kTrain);
    const std::vector<CorrectedPose>& poses = poses_.state().poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      const Rigid3 motion = poses[i].cam_from_world * given_views_[i].cam_from_world.Inverse();
      result.push_back(
          {scene_.views[size_t(views[i])].name, poses[i].cam_from_world,
           glm::degrees(glm::length(RotationVector(motion.rotation))),
           glm::length(motion.Inverse().translation),
           poses[i].depth > 0 ? PictureShift(given_views_[i].camera, motion, poses[i].depth) : 0});
    }
    return result;
  }

 private:
  // A run by iterations is taken to make 40 steps per second.
  double ExpectedSeconds() const {
    const double by_iterations = double(options_.iterations) / 40.0;
    if (options_.time_limit_s <= 0) return by_iterations;
    if (options_.iterations == 0) return options_.time_limit_s;
    return std::min(by_iterations, options_.time_limit_s);
  }

  void Begin(const RadianceField& start) {
    if (options_.max_vertices > 0 && options_.max_vertices < start.mesh.positions.size()) {
      LogWarning(
          "at most {} vertices are allowed, but the mesh starts with {}: it is not refined; allow "
          "more, or start coarser (see tetrec-tetrahedralize)",
          options_.max_vertices, start.mesh.positions.size());
    }
    FieldState state;
    if (stage_.resume() && fs::exists(checkpoint_path_)) {
      state_ = ReadCheckpoint(checkpoint_path_);
      mesh_ = std::move(state_.mesh);
      state = std::move(state_.state);
      if (state.layout.storage != options_.storage) {
        throw DataError(fmt::format(
            "{}: contains a field with one row per {}, not per {}; force a fresh run",
            checkpoint_path_.string(), RowName(state.layout.storage), RowName(options_.storage)));
      }
      round_iteration_ = state_.iteration;
      exposure_ = ResumedExposure(std::move(state_.exposure));
      poses_ = ResumedPoses(std::move(state_.poses));
      LogInfo("continues from iteration {} after {:.0f} s", state_.iteration, state_.seconds);
    } else {
      if (stage_.resume()) LogInfo("no checkpoint was saved: starts at the first iteration");
      mesh_ = start.mesh;
      state = WithHarmonics(StateOf(WithStorage(start, options_.storage)), 0);
      if (EstimatesExposure()) exposure_ = ExposureEstimate(set_.views.size());
      if (CorrectsPoses()) poses_ = PoseEstimate(given_views_);
    }
    UseViews();
    if (exposure_.is_on()) renderer_->SetExposures(exposure_.State(*renderer_).exposures);
    PutState(std::move(state));
  }

  // Gives the renderer a state of mesh_, with no density in the space of the cameras.
  void PutState(FieldState state) {
    std::vector<float> rate_shares(state.rows(), 1.0f);
    if (!camera_space_.empty()) {
      const std::vector<uint8_t> is_empty =
          InsideCapsules(RowPositions(mesh_, state.layout.storage), camera_space_);
      for (size_t row = 0; row < is_empty.size(); ++row) {
        if (!is_empty[row]) continue;
        rate_shares[row] = 0.0f;
        state.parameters[row * size_t(state.layout.Components()) + kDensityOffset] =
            kLeastLogDensity;
      }
      emptied_rows_ = uint64_t(std::count(is_empty.begin(), is_empty.end(), uint8_t{1}));
    }
    renderer_->SetState(mesh_, state);
    renderer_->SetRateShares(rate_shares);
    degree_ = state.layout.HarmonicsDegree();
    batches_.UseFewViews(degree_ > 0);
  }

  bool KeepsJudgingPictures(double done) const {
    return options_.judging_pictures == JudgingPictures::kKept &&
           done < options_.schedule.last_judging;
  }

  // Chooses which pixels are learned. The judging pictures are learned in the last part of a run.
  void UseTargets(double done) {
    learns_all_ = !KeepsJudgingPictures(done);
    ListBlocks(set_, learns_all_ ? std::vector<uint8_t>() : judging_.is_whole);
    renderer_->SetTargets(set_.views, learns_all_ ? set_.targets : TargetsToLearn(set_, judging_));
  }

  // Leaves the renderer with the targets to learn.
  Judgement JudgeField() {
    renderer_->SetTargets(set_.views, TargetsToJudge(set_, judging_));
    const Judgement judgement = Judge(*renderer_, judging_, BackgroundColor(scene_.background));
    UseTargets(Done());
    return judgement;
  }

  bool EstimatesExposure() const {
    if (options_.exposure == ExposureMode::kAuto) return !scene_.has_alpha;
    return options_.exposure == ExposureMode::kOn;
  }

  ExposureEstimate ResumedExposure(ExposureState state) const {
    const size_t expected = EstimatesExposure() && set_.views.size() > 1 ? set_.views.size() : 0;
    if (state.exposures.size() != expected) {
      throw DataError(
          fmt::format("{}: contains the exposures of {} photos, not {}; force a fresh "
                      "run",
                      checkpoint_path_.string(), state.exposures.size(), expected));
    }
    return ExposureEstimate(std::move(state));
  }

  double Done() const {
    double done = 0;
    if (options_.time_limit_s > 0) done = state_.seconds / options_.time_limit_s;
    if (options_.iterations > 0) {
      done = std::max(done, double(state_.iteration) / double(options_.iterations));
    }
    return done;
  }

  bool IsTaught() const {
    return options_.iterations > 0 ||
           state_.iteration - round_iteration_ >= options_.schedule.min_round_steps;
  }

  // Counts the step.
  AdamUpdate NextUpdate(double done) { return UpdateAt(++state_.iteration, done); }

  AdamUpdate UpdateAt(uint64_t iteration, double done) const {
    const double share = RateShare(options_.schedule, done);
    return {.step = uint32_t(std::min<uint64_t>(iteration, 1u << 30)),
            .color_rate = options_.color_rate * share,
            .density_rate = options_.density_rate * share,
            .harmonics_rate = options_.harmonics_rate * share,
            .max_density = options_.max_density,
            .density_decay = options_.density_decay};
  }

  // Corrects the cameras by the field as it is. What the first sweep gains on the judging pictures
  // decides whether corrections are kept at all.
  void CorrectPoses() {
    const Timer timer;
    const bool decides = poses_.state().sweeps == 0;
    const std::vector<TargetImage> targets = TargetsToLearn(set_, judging_);
    const size_t changed =
        poses_.Sweep(*renderer_,
                     {given_views_, targets, exposure_.State(*renderer_).exposures,
                      BackgroundColor(scene_.background)},
                     options_.seed);
    UseViews();
    LogInfo("sweep {} over the cameras: {} of {} corrected, {:.1f} s", poses_.state().sweeps,
            changed, set_.views.size(), timer.seconds());
    if (decides) KeepPosesIf(changed > 0 ? GainOfPoses() : 0);
  }

  // What the corrections gain on the judging pictures with the field as it is [dB].
  double GainOfPoses() {
    const double corrected = JudgeField().psnr;
    set_.views = given_views_;
    const double given = JudgeField().psnr;
    UseViews();
    return corrected - given;
  }

  void KeepPosesIf(double gain) {
    LogInfo("the judging pictures change by {:+.2f} dB with the corrected cameras: {}", gain,
            gain >= kLeastPoseGain_db ? "they are kept" : "all stay where they were found");
    if (gain >= kLeastPoseGain_db) {
      state_.best_psnr += gain;  // of the same field, or one before it
    } else {
      poses_.GiveUp();
      UseViews();
    }
  }

  // Puts the cameras where they are now.
  void UseViews() {
    set_.views = given_views_;
    for (size_t i = 0; i < poses_.state().poses.size(); ++i) {
      set_.views[i].cam_from_world = poses_.state().poses[i].cam_from_world;
    }
    UseTargets(Done());
  }

  bool CorrectsPoses() const {
    if (options_.poses == PoseMode::kAuto) return CamerasWereEstimated(scene_folder_);
    return options_.poses == PoseMode::kOn;
  }

  PoseEstimate ResumedPoses(PoseState state) const {
    if (!state.poses.empty() && state.poses.size() != set_.views.size()) {
      throw DataError(fmt::format("{}: contains the poses of {} cameras, not {}; force a fresh run",
                                  checkpoint_path_.string(), state.poses.size(),
                                  set_.views.size()));
    }
    return PoseEstimate(std::move(state));
  }

  // Judges the field that the last refinement led to. If that is worse than before, the run returns
  // to the field before it, and the mesh stays as it was then.
  bool IsWorthRefining() {
    const Judgement now = JudgeField();
    LogInfo(
        "judging pictures before round {}: {:.2f} dB, standard error {:.2f} (views {:.2f}, tiles "
        "{:.2f})",
        state_.rounds + 1, now.psnr, now.standard_error, now.views_psnr, now.tiles_psnr);
    if (state_.rounds == 0 || now.psnr > state_.best_psnr - options_.schedule.judged_loss) {
      if (state_.rounds == 0 || now.psnr > state_.best_psnr) SaveBest(now.psnr);
      return true;
    }
    Checkpoint best = ReadCheckpoint(best_path_);
    LogInfo(
        "round {} lost {:.2f} dB on the judging pictures: returns to {} vertices and refines no "
        "more",
        state_.rounds, state_.best_psnr - now.psnr, WithThousands(best.mesh.positions.size()));
    mesh_ = std::move(best.mesh);
    PutState(WithHarmonics(best.state, degree_));
    state_.rounds = uint32_t(options_.schedule.rounds);
    return false;
  }

  void SaveBest(double psnr) {
    state_.best_psnr = psnr;
    Checkpoint best = state_;
    best.mesh = mesh_;
    best.state = renderer_->ReadState();
    WriteCheckpoint(best_path_, best);
  }

  // Unlocks a degree of view-dependent colour, or judges one, if that is due.
  bool StepHarmonics(double done) {
    const HarmonicsStep step = NextHarmonicsStep(options_.harmonics, state_.harmonics, done);
    if (step == HarmonicsStep::kUnlock) UnlockHarmonics();
    if (step == HarmonicsStep::kJudge) JudgeHarmonics(done);
    return step != HarmonicsStep::kNone;
  }

  void UnlockHarmonics() {
    if (options_.harmonics == HarmonicsChoice::kAuto && learns_all_) {
      LogInfo("colours do not depend on the view: no judging pictures are kept that could tell");
      state_.harmonics.closed = 1;
      return;
    }
    ++state_.harmonics.unlocked;
    PutState(WithHarmonics(renderer_->ReadState(), degree_ + 1));
    LogInfo("colours depend on the view by harmonics of degree {}", degree_);
  }

  // Trains on with the highest degree and without it, by the same batches, and keeps the better.
  void JudgeHarmonics(double done) {
    state_.harmonics.judged = state_.harmonics.unlocked;
    if (learns_all_) return;  // too late to judge: the degree stays
    const int degree = degree_;
    const uint64_t steps = TrialSteps(state_.iteration);
    const FieldState before = renderer_->ReadState();
    const double with = TrialPsnr(steps, done);
    FieldState trained = renderer_->ReadState();
    PutState(WithoutHighestDegree(mesh_, before, set_.views));
    const double without = TrialPsnr(steps, done);
    const bool stays = with > without + kLeastHarmonicsGain;
    LogInfo(
        "judging pictures after {} steps: {:.2f} dB with harmonics of degree {}, {:.2f} dB "
        "without: "
        "{}",
        steps, with, degree, without, stays ? "they stay" : "they are dropped");
    if (stays) PutState(std::move(trained));
    if (!stays) state_.harmonics.closed = 1;
    state_.iteration += steps;
  }

  // The PSNR of the judging pictures after some steps more, which are not counted.
  double TrialPsnr(uint64_t steps, double done) {
    for (uint64_t i = 0; i < steps; ++i) {
      const TrainingBatch batch = batches_.Draw(state_.iteration + i);
      state_.rays += batch.rays();
      renderer_->Step(batch, UpdateAt(state_.iteration + i + 1, done));
    }
    return JudgeField().psnr;
  }

  void RefineOnce() {
    if (!learns_all_ && !IsWorthRefining()) return;
    const Timer timer;
    const std::vector<float> error =
        LookAtErrors(*renderer_, set_, batches_, options_, mesh_.tets.size(), state_.iteration);
    const double look_seconds = timer.seconds();
    RefineOptions refine;
    refine.growth =
        RoundGrowth(options_.schedule, int(state_.rounds), mesh_.positions.size(), max_vertices_);
    refine.max_vertices = max_vertices_;
    refine.seed = options_.seed + state_.rounds;
    const size_t vertices_before = mesh_.positions.size();
    RefineResult result = Refine(mesh_, renderer_->ReadState(), error, refine);
    mesh_ = std::move(result.mesh);
    PutState(std::move(result.state));
    ++state_.rounds;
    round_iteration_ = state_.iteration;
    LogInfo(
        "round {}: {} -> {} vertices, {} tets: {} edges split, {} empty vertices dropped; errors "
        "{:.1f} s, mesh {:.1f} s",
        state_.rounds, WithThousands(vertices_before), WithThousands(mesh_.positions.size()),
        WithThousands(mesh_.tets.size()), WithThousands(result.split_edges),
        WithThousands(result.dropped_empty), look_seconds, timer.seconds() - look_seconds);
  }

  void SaveCheckpoint(uint64_t metrics_bytes) {
    Checkpoint checkpoint = state_;
    checkpoint.metrics_bytes = metrics_bytes;
    checkpoint.mesh = mesh_;
    checkpoint.state = renderer_->ReadState();
    checkpoint.exposure = exposure_.State(*renderer_);
    checkpoint.poses = poses_.state();
    WriteCheckpoint(checkpoint_path_, checkpoint);
  }

  TrainingRow Row(const Averages& averages, std::optional<double> heldout_psnr,
                  const char* phase) const {
    TrainingRow row;
    row.iteration = state_.iteration;
    row.seconds = state_.seconds;
    row.rays = state_.rays;
    if (averages.count > 0) {
      row.loss = averages.Loss();
      row.train_psnr = averages.Psnr();
    }
    row.heldout_psnr = heldout_psnr;
    row.tets = mesh_.tets.size();
    row.vertices = mesh_.positions.size();
    row.phase = phase;
    return row;
  }

  void Report(double psnr) {
    const RenderCounts counts = renderer_->counts();
    stage_.Count("iterations", state_.iteration);
    stage_.Count("training_rays", state_.rays);
    stage_.Count("tets", mesh_.tets.size());
    stage_.Count("vertices", mesh_.positions.size());
    stage_.Count("rounds", state_.rounds);
    stage_.Count("emptied_rows", emptied_rows_);
    stage_.Count("harmonics_degree", degree_);
    stage_.Count("rays", counts.rays);
    if (ChecksRays(options_.renderer)) stage_.Count("lost_rays", counts.lost_rays);
    if (options_.renderer.deterministic) stage_.Count("clamped_addends", counts.clamped_addends);
    stage_.Seconds("optimize", state_.seconds);
    if (!watched_.empty()) stage_.Count("watched_psnr", psnr);
    if (counts.lost_rays > 0) {
      LogWarning("{} of {} rays were lost on their way through the mesh", counts.lost_rays,
                 WithThousands(counts.rays));
    }
    if (counts.clamped_addends > 0) {
      LogWarning("{} addends were too large for the fixed-point sums of gradients and scores",
                 WithThousands(counts.clamped_addends));
    }
    LogInfo("{} iterations, {} rays in {:.1f} s; {} vertices, {} tets{}",
            WithThousands(state_.iteration), WithThousands(state_.rays), state_.seconds,
            WithThousands(mesh_.positions.size()), WithThousands(mesh_.tets.size()),
            watched_.empty()
                ? ""
                : fmt::format("; {:.2f} dB on {} watched views", psnr, watched_.size()));
    LogKernelTimes(options_.renderer, *renderer_);
  }

  const OptimizeOptions& options_;
  fs::path scene_folder_;
  const Scene& scene_;
  Stage& stage_;
  TrainingSet set_;                      // its cameras are the corrected ones
  std::vector<RenderView> given_views_;  // with the scene's own cameras
  std::vector<int> watched_;
  std::unique_ptr<TrainingRenderer> renderer_;
  BatchDrawer batches_;
  std::vector<Capsule> camera_space_;
  uint64_t emptied_rows_ = 0;  // in the camera space
  JudgingSet judging_;
  bool learns_all_ = true;  // the judging pictures, too
  int degree_ = 0;          // of harmonics
  fs::path checkpoint_path_, best_path_;
  uint64_t max_vertices_ = 0;
  uint64_t round_iteration_ = 0;  // at the last refinement
  ExposureEstimate exposure_;
  PoseEstimate poses_;
  Checkpoint state_;  // counters; its mesh, field state and exposures are used on disk only
  TetMesh mesh_;
};

FieldWorld WorldOf(const Scene& scene, const fs::path& scene_folder, const fs::path& folder) {
  FieldWorld world{scene.input_from_world, scene.subject_bounds, {}, {}};
  for (const View& view : scene.views) {
    world.cameras_in_world.push_back(view.cam_from_world.Inverse().translation);
  }
  world.scene = fs::relative(scene_folder, folder).generic_string();
  return world;
}

// Writes what was estimated of the photos, and says so where they differ much.
void WriteExposures(const std::vector<PhotoExposure>& exposures, Stage& stage) {
  if (exposures.empty()) return;
  WritePhotoExposures(stage.Output(kPhotoExposuresFile), exposures);
  const auto uneven = std::count_if(exposures.begin(), exposures.end(), IsUneven);
  stage.Count("uneven_photos", uint64_t(uneven));
  if (uneven > 0) LogWarning("{}", UnevenWarning(size_t(uneven), exposures.size()));
}

// The same for the cameras.
void WriteCorrections(const std::vector<CameraCorrection>& corrections, Stage& stage) {
  if (corrections.empty()) return;
  WriteCameraCorrections(stage.Output(kCameraCorrectionsFile), corrections);
  const auto moved = std::count_if(corrections.begin(), corrections.end(), MovedMuch);
  stage.Count("moved_cameras", uint64_t(moved));
  if (moved > 0) LogWarning("{}", MovedMuchWarning(size_t(moved), corrections.size()));
}

}  // namespace

void RunOptimize(const OptimizeOptions& options, Stage& stage) {
  const fs::path start_folder = stage.Input("TETRAHEDRA");
  const fs::path scene_folder = PreviousStage(start_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const RadianceField start = ReadField(start_folder / "field.tetf");
  CheckConvexDomain(start.mesh);  // refinement fills it with new tets
  Trainer trainer(options, scene_folder, scene, stage);
  WriteField(stage.Output("field.tetf"), trainer.Run(start));
  WriteExposures(trainer.Exposures(), stage);
  WriteCorrections(trainer.Corrections(), stage);
  WriteFieldWorld(stage.Output(kFieldWorldFile), WorldOf(scene, scene_folder, stage.folder()));
}

}  // namespace tetrec
