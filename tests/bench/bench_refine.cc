// Time of the first and the last of many rounds of refinement, per tet of the mesh that the
// round makes: the same, if a scheme takes time in proportion to the mesh. For example
//   bench_refine --scheme prism --rounds 20
#include "benchmark/bench_scene.h"
#include "benchmark/stopwatch.h"
#include "command/word_option.h"
#include "core/quantile.h"
#include "core/random.h"
#include "mesh/delaunay.h"
#include "refine/refine.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace tetrec {
namespace {

struct RefineBenchOptions {
  RefineScheme scheme = RefineScheme::kPrism;
  uint64_t tets = 5000;  // of the first mesh, about
  int rounds = 20, turns = 9;
  double growth = 1.25;  // of the vertices in each round
};

// Rounds of a fit follow the pictures' errors; here they follow the distance from a point.
RefineScores ScoresAround(const TetMesh& mesh, const glm::vec3& center) {
  RefineScores scores;
  for (const glm::vec3& p : mesh.positions) {
    scores.of_vertices.push_back(1.0f / (0.1f + glm::distance(p, center)));
  }
  return scores;
}

// What a round starts with.
struct RoundStart {
  TetMesh mesh;
  FieldState state;
  RefineScores scores;
};

RefineResult RefineOnce(const RoundStart& start, const RefineBenchOptions& options) {
  RefineOptions refine;
  refine.scheme = options.scheme;
  refine.growth = options.growth;
  refine.min_edge = 0;
  return Refine(start.mesh, start.state, start.scores, refine);
}

// Microseconds per tet of the new mesh, over as many repetitions as make a million tets.
double MicrosecondsPerTet(const RoundStart& start, const RefineBenchOptions& options) {
  double tets = 0;
  const Seconds seconds = Measure([&] {
    while (tets < 1e6) tets += double(RefineOnce(start, options).mesh.tets.size());
  });
  return 1e6 * seconds.wall / tets;
}

// The first and the last round take turns, because the speed of a shared machine changes.
void Compare(const RoundStart& first, const RoundStart& last, const RefineBenchOptions& options) {
  std::vector<double> of_first, of_last, ratios;
  for (int turn = 0; turn < options.turns; ++turn) {
    of_first.push_back(MicrosecondsPerTet(first, options));
    of_last.push_back(MicrosecondsPerTet(last, options));
    ratios.push_back(of_last.back() / of_first.back());
  }
  fmt::print(
      "us per tet, medians of {} turns: first round {:.3f}, last round {:.3f}; ratio {:.2f}\n",
      options.turns, Median(of_first), Median(of_last), Median(ratios));
}

void Run(const RefineBenchOptions& options) {
  const RadianceField ball =
      BallOn(BuildDelaunay(JitteredCube(GridOfTets(double(options.tets)))).mesh);
  RoundStart first, start{ball.mesh, StateOf(ball), {}};
  Random random(1);
  for (int round = 1; round <= options.rounds; ++round) {
    glm::vec3 center;
    for (int k = 0; k < 3; ++k) center[k] = float(random.Uniform());
    start.scores = ScoresAround(start.mesh, center);
    CompleteScores(start.mesh, start.scores);
    if (round == 1) first = start;
    if (round == options.rounds) break;
    RefineResult result = RefineOnce(start, options);
    start = {std::move(result.mesh), std::move(result.state), {}};
  }
  fmt::print("{} rounds of {}, from {} tets to {} before the last\n", options.rounds,
             Name(options.scheme), first.mesh.tets.size(), start.mesh.tets.size());
  Compare(first, start, options);
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  tetrec::RefineBenchOptions options;
  CLI::App app("Time of the first and the last round of refinement, per tet");
  tetrec::AddWordOption(app, "--scheme", options.scheme, "");
  app.add_option("--tets", options.tets, "approximate number of tets of the first mesh")
      ->capture_default_str();
  app.add_option("--rounds", options.rounds)->capture_default_str();
  app.add_option("--growth", options.growth, "of the vertices in each round")
      ->capture_default_str();
  app.add_option("--turns", options.turns)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    tetrec::Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_refine: {}\n", error.what());
    return 1;
  }
}
