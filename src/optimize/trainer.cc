// The optimisation of a radiance field against the pictures of a scene.
#include "optimize/trainer.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/progress.h"
#include "field/change_storage.h"
#include "optimize/checkpoint.h"
#include "optimize/random.h"
#include "optimize/refine.h"
#include "optimize/training_set.h"
#include "render/kernel_table.h"
#include "render/picture.h"
#include "scene/image.h"
#include "shared/gpu_types.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetricsHeader =
    "iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase\n";

// Appends rows to metrics.csv; a resumed run first cuts off what came after its checkpoint.
class MetricsFile {
 public:
  MetricsFile(const fs::path& path, uint64_t keep_bytes) : path_(path) {
    if (keep_bytes > 0 && fs::exists(path) && fs::file_size(path) >= keep_bytes) {
      fs::resize_file(path, keep_bytes);
    } else {
      WriteText(path, kMetricsHeader);
    }
  }
  void Add(const std::string& row) {
    std::ofstream out(path_, std::ios::app | std::ios::binary);
    out << row << '\n';
    out.flush();
    if (!out) throw EnvironmentError(fmt::format("{}: cannot write (disk full?)", path_.string()));
  }
  uint64_t bytes() const { return fs::file_size(path_); }

 private:
  fs::path path_;
};

// Of a tile for D-SSIM where a batch may have several: 32 x 32 pixels.
constexpr size_t kTileBlocks = 128;
constexpr int kLeastDssimRays = 256;  // a tile of 16 x 16 pixels, with room for windows of 11 x 11
constexpr int kLeastDssimPicture = 12;  // [px] whole blocks that hold a window

std::vector<int> EvenlyChosen(const std::vector<int>& all, int count) {
  std::vector<int> chosen;
  const int n = std::min<int>(count, int(all.size()));
  for (int i = 0; i < n; ++i) chosen.push_back(all[size_t(i) * all.size() / n]);
  return chosen;
}

glm::vec3 DrawColor(uint64_t seed, uint64_t iteration) {
  Random random(seed ^ 0xB0Cull, iteration);
  const float r = float(random.Uniform()), g = float(random.Uniform()), b = float(random.Uniform());
  return {r, g, b};
}

// Mean losses since the last row of metrics.
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

class Trainer {
 public:
  Trainer(const OptimizeOptions& options, const fs::path& scene_folder, const Scene& scene,
          Stage& stage)
      : options_(options),
        scene_folder_(scene_folder),
        scene_(scene),
        stage_(stage),
        set_(LoadTrainingSet(scene_folder, scene, scene.ViewsOf(Split::kTrain))),
        watched_(EvenlyChosen(Watchable(scene), options.watched_views)),
        renderer_(CreateRenderer(options.renderer)),
        checkpoint_path_(stage.Scratch("checkpoint.bin")) {
    if (options.loss.dssim > 0) CheckRoomForWindows();
    renderer_->SetTargets(set_.views, set_.targets);
    max_vertices_ = options.max_vertices > 0 ? options.max_vertices
                                             : AffordableVertices(ExpectedSeconds(), set_.pixels);
    stage.Device(renderer_->DescribeDevice());
    LogInfo("{} training views, {} pixels; device {}; up to {} vertices", set_.views.size(),
            WithThousands(set_.pixels), renderer_->DescribeDevice()["name"].get<std::string>(),
            WithThousands(max_vertices_));
  }

  RadianceField Run(const RadianceField& start) {
    Begin(start);
    MetricsFile metrics(stage_.Output("metrics.csv"), state_.metrics_bytes);
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
      averages.Add(renderer_->Step(NextStep(done)));
      if (done - last_row >= 0.02) {
        last_row = done;
        std::string psnr;
        if (!watched_.empty() && done - last_watch >= 0.1) {
          last_watch = done;
          watched_psnr = WatchPsnr(*renderer_, scene_folder_, scene_, watched_);
          has_watched = true;
          psnr = fmt::format("{:.3f}", watched_psnr);
        }
        metrics.Add(Row(averages, psnr, "optimise"));
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
        SaveCheckpoint(metrics.bytes());
      }
    }
    state_.seconds = seconds_before + timer.seconds();
    if (StopRequested()) {
      SaveCheckpoint(metrics.bytes());
      throw Interrupted(
          fmt::format("stopped at iteration {} after {:.0f} s; the same command goes on from here",
                      state_.iteration, state_.seconds));
    }
    const VertexState state = renderer_->ReadVertexState();
    const double psnr =
        watched_.empty() ? 0 : WatchPsnr(*renderer_, scene_folder_, scene_, watched_);
    metrics.Add(Row(averages, watched_.empty() ? "" : fmt::format("{:.3f}", psnr), "end"));
    Report(psnr);
    return ToField(state);
  }

 private:
  void CheckRoomForWindows() const {
    for (const TargetImage& target : set_.targets) {
      if (std::min(target.width, target.height) >= kLeastDssimPicture) continue;
      throw DataError(fmt::format(
          "{}: a picture of {}x{} px is too small for D-SSIM, which needs {}; use --loss l1 or l2",
          scene_folder_.string(), target.width, target.height, kLeastDssimPicture));
    }
  }

  // Validation views where there are any: test views are for the end.
  static std::vector<int> Watchable(const Scene& scene) {
    const std::vector<int> validation = scene.ViewsOf(Split::kValidation);
    return validation.empty() ? scene.HeldOutViews() : validation;
  }

  // For what the time affords, a run by iterations counts 40 steps a second.
  double ExpectedSeconds() const {
    const double by_iterations = double(options_.iterations) / 40.0;
    if (options_.time_limit_s <= 0) return by_iterations;
    if (options_.iterations == 0) return options_.time_limit_s;
    return std::min(by_iterations, options_.time_limit_s);
  }

  void Begin(const RadianceField& start) {
    if (options_.max_vertices > 0 && options_.max_vertices < start.mesh.positions.size()) {
      LogWarning(
          "--max-vertices is {}, but the mesh starts with {}: it is not refined; allow more, or "
          "start coarser (tetrec-tetrahedralize --help)",
          options_.max_vertices, start.mesh.positions.size());
    }
    VertexState state;
    if (stage_.resume() && fs::exists(checkpoint_path_)) {
      state_ = ReadCheckpoint(checkpoint_path_);
      mesh_ = std::move(state_.mesh);
      state = std::move(state_.state);
      if (state.storage != options_.storage) {
        throw DataError(fmt::format("{}: holds a field with one row a {}, not a {}; use --force",
                                    checkpoint_path_.string(), RowName(state.storage),
                                    RowName(options_.storage)));
      }
      round_iteration_ = state_.iteration;
      LogInfo("goes on from iteration {} after {:.0f} s", state_.iteration, state_.seconds);
    } else {
      if (stage_.resume()) LogInfo("no checkpoint was saved: begins at the first iteration");
      mesh_ = start.mesh;
      state.parameters = ParametersOf(WithStorage(start, options_.storage));
      state.storage = options_.storage;
      state.first_moment.assign(state.parameters.size(), glm::vec4(0.0f));
      state.second_moment.assign(state.parameters.size(), glm::vec4(0.0f));
    }
    renderer_->SetVertexState(mesh_, state);
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

  TrainingStep NextStep(double done) {
    const double share = RateShare(options_.schedule, done);
    TrainingStep step;
    step.tiles = DrawBatch();
    step.blocks = blocks_;
    step.loss = options_.loss.pixel;
    step.dssim_weight = float(options_.loss.dssim);
    step.background_srgb = TrainingBackground(state_.iteration);
    step.jitter_px = float(options_.jitter_px);
    step.seed = uint32_t(Random(options_.seed, state_.iteration ^ 0x717u).Next());
    step.adam_step = uint32_t(std::min<uint64_t>(++state_.iteration, 1u << 30));
    step.adam.color_rate = float(options_.color_rate * share);
    step.adam.density_rate = float(options_.density_rate * share);
    step.adam.max_density = float(options_.max_density);
    step.adam.density_decay = float(options_.density_decay);
    state_.rays += blocks_.size() * kRaysPerBlock;
    return step;
  }

  // Fills blocks_; the shape of its tiles where it is made of them.
  TileShape DrawBatch() {
    const size_t count = size_t(options_.rays_per_step) / kRaysPerBlock;
    const bool with_dssim = options_.loss.dssim > 0;
    if (!with_dssim && !renderer_->NeedsTiles()) {
      blocks_ = DrawBlocks(set_, count, options_.subject_share, options_.seed, state_.iteration);
      return {};
    }
    const size_t tiles = renderer_->NeedsTiles() ? 1 : std::max<size_t>(1, count / kTileBlocks);
    DrawnTiles drawn = DrawTiles(set_, tiles, count / tiles, options_.subject_share, options_.seed,
                                 state_.iteration);
    blocks_ = std::move(drawn.blocks);
    return drawn.shape;
  }

  glm::vec3 TrainingBackground(uint64_t iteration) const {
    return options_.random_background ? DrawColor(options_.seed, iteration)
                                      : BackgroundColor(scene_.background);
  }

  void RefineOnce() {
    const Timer timer;
    const std::vector<float> error = LookAtErrors();
    const double look_seconds = timer.seconds();
    RefineOptions refine;
    refine.growth =
        RoundGrowth(options_.schedule, int(state_.rounds), mesh_.positions.size(), max_vertices_);
    refine.max_vertices = max_vertices_;
    refine.seed = options_.seed + state_.rounds;
    const size_t vertices_before = mesh_.positions.size();
    RefineResult result = Refine(mesh_, renderer_->ReadVertexState(), error, refine);
    mesh_ = std::move(result.mesh);
    renderer_->SetVertexState(mesh_, result.state);
    ++state_.rounds;
    round_iteration_ = state_.iteration;
    LogInfo(
        "round {}: {} -> {} vertices, {} tets: {} edges split, {} empty vertices dropped; errors "
        "{:.1f} s, mesh {:.1f} s",
        state_.rounds, WithThousands(vertices_before), WithThousands(mesh_.positions.size()),
        WithThousands(mesh_.tets.size()), WithThousands(result.split_edges),
        WithThousands(result.dropped_empty), look_seconds, timer.seconds() - look_seconds);
  }

  // Every block at most once, in random order, as many as the mesh needs to be judged.
  std::vector<float> LookAtErrors() {
    std::vector<RayBlock> blocks = set_.blocks;
    Random random(options_.seed ^ 0x5C0ull, state_.iteration);
    size_t wanted =
        std::min(blocks.size(),
                 size_t(options_.score_rays_per_tet * double(mesh_.tets.size())) / kRaysPerBlock);
    if (options_.renderer.deterministic && wanted > kMostScoredRays / kRaysPerBlock) {
      LogInfo("looks at {} of {} wanted rays: fixed-point scores hold no more",
              WithThousands(kMostScoredRays), WithThousands(wanted * kRaysPerBlock));
      wanted = kMostScoredRays / kRaysPerBlock;
    }
    for (size_t i = 0; i < wanted; ++i) {
      std::swap(blocks[i], blocks[i + random.Below(uint32_t(blocks.size() - i))]);
    }
    renderer_->ClearScores();
    constexpr size_t kBatch = 4096;
    for (size_t first = 0; first < wanted; first += kBatch) {
      TrainingStep step;
      step.blocks = std::span(blocks).subspan(first, std::min(kBatch, wanted - first));
      step.background_srgb = TrainingBackground(state_.iteration + first);
      renderer_->AddScores(step);
    }
    return renderer_->ReadScores();
  }

  void SaveCheckpoint(uint64_t metrics_bytes) {
    Checkpoint checkpoint = state_;
    checkpoint.metrics_bytes = metrics_bytes;
    checkpoint.mesh = mesh_;
    checkpoint.state = renderer_->ReadVertexState();
    WriteCheckpoint(checkpoint_path_, checkpoint);
  }

  std::string Row(const Averages& averages, const std::string& heldout_psnr,
                  const char* phase) const {
    const std::string losses =
        averages.count > 0 ? fmt::format("{:.6g},{:.3f}", averages.Loss(), averages.Psnr()) : ",";
    return fmt::format("{},{:.3f},{},{},{},{},{},{}", state_.iteration, state_.seconds, state_.rays,
                       losses, heldout_psnr, mesh_.tets.size(), mesh_.positions.size(), phase);
  }

  void Report(double psnr) {
    const RenderCounts counts = renderer_->counts();
    stage_.Count("iterations", state_.iteration);
    stage_.Count("training_rays", state_.rays);
    stage_.Count("tets", mesh_.tets.size());
    stage_.Count("vertices", mesh_.positions.size());
    stage_.Count("rounds", state_.rounds);
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

  RadianceField ToField(const VertexState& state) const {
    RadianceField field;
    field.mesh = mesh_;
    field.storage = state.storage;
    for (const glm::vec4& row : state.parameters) {
      field.density.push_back(std::exp(row.a));
      field.color_srgb.emplace_back(row);
    }
    CheckField(field);
    return field;
  }

  const OptimizeOptions& options_;
  fs::path scene_folder_;
  const Scene& scene_;
  Stage& stage_;
  TrainingSet set_;
  std::vector<int> watched_;
  std::unique_ptr<TrainingRenderer> renderer_;
  fs::path checkpoint_path_;
  uint64_t max_vertices_ = 0;
  uint64_t round_iteration_ = 0;  // at the last refinement
  Checkpoint state_;              // counters; its mesh and vertex state only on disk
  TetMesh mesh_;
  std::vector<RayBlock> blocks_;
};

void WriteWorld(const fs::path& path, const Scene& scene, const fs::path& scene_folder) {
  nlohmann::json rotation = nlohmann::json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      rotation.push_back(scene.input_from_world.rotation[column][row]);
    }
  }
  const auto list = [](const glm::dvec3& v) { return nlohmann::json{v.x, v.y, v.z}; };
  nlohmann::json cameras = nlohmann::json::array();
  for (const View& view : scene.views) {
    cameras.push_back(list(view.cam_from_world.Inverse().translation));
  }
  WriteJson(path,
            {{"schema", 1},
             {"input_from_world",
              {{"scale", scene.input_from_world.scale},
               {"rotation", rotation},
               {"translation", list(scene.input_from_world.translation)}}},
             {"subject_bounds",
              {{"min", list(scene.subject_bounds.min)}, {"max", list(scene.subject_bounds.max)}}},
             {"cameras_in_world", cameras},
             {"scene", fs::relative(scene_folder, path.parent_path()).generic_string()}});
}

}  // namespace

void OptimizeOptions::Check() const {
  const auto fail = [](const char* option, double value, const char* want) {
    throw UsageError(fmt::format("{} is {}, must be {}", option, value, want));
  };
  if (!(time_limit_s >= 0)) fail("--time-limit", time_limit_s, "at least 0 s");
  if (time_limit_s == 0 && iterations == 0) {
    throw UsageError("--time-limit and --iterations are both 0: give one");
  }
  if (renderer.deterministic && (time_limit_s > 0 || iterations == 0)) {
    throw UsageError(
        "--deterministic: a run by time ends where the machine's speed takes it; give --iterations "
        "and --time-limit 0");
  }
  if (rays_per_step < kRaysPerBlock || rays_per_step > 1 << 22) {
    fail("--rays", rays_per_step, "8 to 4194304");
  }
  if (loss.dssim > 0 && rays_per_step < kLeastDssimRays) {
    fail("--rays", rays_per_step, "at least 256 for a loss with D-SSIM, whose windows need tiles");
  }
  if (!(checkpoint_interval_s >= 0)) {
    fail("--checkpoint-interval", checkpoint_interval_s, "at least 0 s");
  }
  if (!(max_density > 0 && max_density <= 1e30)) fail("--max-density", max_density, "above 0");
}

double WatchPsnr(Renderer& renderer, const fs::path& scene_folder, const Scene& scene,
                 std::span<const int> views) {
  double sum = 0;
  size_t judged_views = 0;
  for (int view : views) {
    const Image stored = ReadImage(scene_folder / scene.views[view].image);
    const bool is_masked = scene.has_masks && stored.channels == 4;
    const Image truth = OverBackground(stored, scene.background);
    const Image picture =
        ToPicture(renderer.Render(MakeRenderView(scene, view), 2), scene.background);
    double squares = 0;
    size_t judged = 0;
    for (size_t i = 0; i < truth.pixels.size(); ++i) {
      if (is_masked && stored.pixels[i / 3 * 4 + 3] < kSeenAlpha) continue;
      const double d = (double(truth.pixels[i]) - picture.pixels[i]) / 255.0;
      squares += d * d;
      ++judged;
    }
    if (judged == 0) continue;
    sum += -10 * std::log10(std::max(squares / double(judged), 1e-10));
    ++judged_views;
  }
  return judged_views == 0 ? 0 : sum / double(judged_views);
}

void RunOptimize(const OptimizeOptions& options, Stage& stage) {
  const fs::path start_folder = stage.Input("TETRAHEDRA");
  const fs::path scene_folder = PreviousStage(start_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const RadianceField start = ReadField(start_folder / "field.tetf");
  CheckConvexDomain(start.mesh);  // refinement fills it with tets anew
  Trainer trainer(options, scene_folder, scene, stage);
  WriteField(stage.Output("field.tetf"), trainer.Run(start));
  WriteWorld(stage.Output("world.json"), scene, scene_folder);
}

}  // namespace tetrec
