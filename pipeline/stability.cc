// tetrec-stability: what breaks and what holds when photos, points, meshes or options are bad.
#include "command/run_command.h"
#include "core/stop_request.h"
#include "stability/stress_report.h"
#include "stability/sweep_report.h"

#include <fmt/format.h>

namespace {

namespace fs = std::filesystem;

// The stages are beside this program.
fs::path ProgramFolder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Runs the stages on a small scene that is damaged in many ways, each run beside one on the\n"
      "scene as it was, and writes what breaks and what holds: stress.html, .json and .csv. With\n"
      "--sweep instead the rates and the regulariser of moving vertices vary, by the DiffTetVR\n"
      "article's motion and by ours: sweep.html, .json and .csv. Runs that are up to date in the\n"
      "output folder are not repeated.\n"
      "Example: tetrec-stability -o runs/stability",
      "tetrec-stability");
  app.option_defaults()->always_capture_default();
  fs::path out, scene;
  tetrec::StressOptions stress;
  tetrec::SweepOptions sweep;
  bool is_sweep = false, is_short = false;
  uint64_t iterations = 0, seed = 1;
  app.add_option("-o,--output", out, "Folder to write; created if missing")->required();
  app.add_option("--scene", scene,
                 "Folder that tetrec-sfm or tetrec-import wrote; by default synthetic photos of a "
                 "ball in a room (with --sweep, two balls with alpha). Small pictures are best");
  app.add_flag("--sweep", is_sweep, "Vary hyperparameters instead of damaging the scene");
  app.add_flag("--short", is_short, "Few runs on few small pictures, in less than a minute");
  app.add_option("--case", stress.cases,
                 "Only these cases, with commas between them, and their twins")
      ->delimiter(',')
      ->default_str("");
  app.add_option("--iterations", iterations,
                 "Steps of a run; 0: 400 (60 with --short), with --sweep 300 (40)");
  app.add_option("--seed", seed, "Random seed of synthetic scenes and of damages");
  app.get_option("--case")->excludes("--sweep");
  return tetrec::RunCommand(app, argc, argv, [&] {
    stress.scene = sweep.scene = scene;
    stress.programs = sweep.programs = ProgramFolder();
    stress.iterations = sweep.iterations = iterations;
    stress.seed = sweep.seed = seed;
    stress.is_short = sweep.is_short = is_short;
    tetrec::CheckOptions(app, [&] { stress.Check(); });
    tetrec::CatchStopSignals();
    fs::create_directories(out);
    if (is_sweep) {
      WriteSweep(RunSweep(sweep, out), sweep, out);
      fmt::print("page: {}\n", (out / "sweep.html").string());
    } else {
      const std::vector<tetrec::StressResult> results = RunStress(stress, out);
      WriteStress(results, stress, out);
      fmt::print("{}\npage: {}\n", StressSummary(results), (out / "stress.html").string());
    }
  });
}
