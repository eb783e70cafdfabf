// Time and memory for one image and its gradients on a mesh of any size, whole or with holes, by
// any renderer. For example
//   /usr/bin/time -v bench_size --tets 4000000 --width 1920 --height 1080 --renderer march
#include "benchmark/bench_scene.h"
#include "benchmark/stopwatch.h"
#include "command/word_option.h"
#include "core/process_memory.h"
#include "mesh/delaunay.h"
#include "mesh/tet_mesh.h"
#include "render/create_renderer.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace tetrec {
namespace {

struct SizeOptions {
  uint64_t tets = 1'000'000;
  int width = 1920, height = 1080, repetitions = 1;
  double removed = 0.0;
  bool ball = false, positions = false;
  RendererOptions renderer;
};

// Removes a share of the tets, and the vertices that no tet is left at.
void RemoveTets(TetMesh& mesh, double share) {
  std::mt19937 random(1);
  std::bernoulli_distribution removed(share);
  std::vector<uint32_t> new_id(mesh.positions.size(), kNoTet);
  std::vector<glm::vec3> positions;
  std::erase_if(mesh.tets, [&](const glm::uvec4&) { return removed(random); });
  for (glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) {
      uint32_t& id = new_id[tet[i]];
      if (id == kNoTet) {
        id = uint32_t(positions.size());
        positions.push_back(mesh.positions[tet[i]]);
      }
      tet[i] = id;
    }
  }
  mesh.positions = std::move(positions);
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
}

// The ball in the cube. With --ball the mesh fills only a ball, so that its hull has many faces.
RadianceField MakeField(const SizeOptions& options) {
  std::vector<glm::vec3> points =
      JitteredCube(GridOfTets(double(options.tets) * (options.ball ? 6.0 / M_PI : 1.0)));
  if (options.ball) {
    std::erase_if(points,
                  [](const glm::vec3& p) { return glm::distance(p, glm::vec3(0.5f)) >= 0.5f; });
  }
  TetMesh mesh = BuildDelaunay(points).mesh;
  if (options.removed > 0.0) RemoveTets(mesh, options.removed);
  return BallOn(std::move(mesh));
}

double PeakMib() { return double(PeakRssBytes()) / (1 << 20); }

void Time(const std::string& what, int repetitions, const std::function<void()>& body) {
  double least = 1e300;
  for (int i = 0; i < repetitions; ++i) least = std::min(least, Measure(body).wall);
  fmt::print("{}: {:.3f} s, peak {:.0f} MiB\n", what, least, PeakMib());
  std::fflush(stdout);
}

void Run(SizeOptions options) {
  options.renderer.Check();
  options.renderer.count_steps = true;
  RadianceField field;
  Time("mesh", 1, [&] { field = MakeField(options); });
  fmt::print("{} tets, {} vertices, {} boundary faces\n", field.mesh.tets.size(),
             field.mesh.positions.size(), MeasureQuality(field.mesh).boundary_faces);
  const auto renderer = CreateProbedRenderer(options.renderer);
  Time("SetField", 1, [&] { renderer->SetField(field); });
  // From outside; the cube fills the height of the image.
  const RenderView view = LookingAt({2.1, 1.3, -0.4}, glm::dvec3(0.5), options.width,
                                    options.height, 1.3 * options.height);
  RenderedImage image;
  Time("Render", options.repetitions, [&] { image = renderer->Render(view, 1); });
  const RenderCounts counts = renderer->counts();
  glm::dvec3 mean(0.0);
  for (const glm::vec3& color : image.color_srgb) mean += glm::dvec3(color);
  mean /= double(image.color_srgb.size());
  fmt::print("mean colour {:.6f} {:.6f} {:.6f}, {} rays, {} lost, {} hit, {} steps\n", mean.r,
             mean.g, mean.b, counts.rays, counts.lost_rays, counts.hit_rays, counts.steps);
  const std::vector<glm::vec4> gradient(image.color_srgb.size(),
                                        glm::vec4(1.0f, -1.0f, 0.5f, 0.1f));
  const GradientParts parts =
      options.positions ? GradientParts::kColorDensityPosition : GradientParts::kColorDensity;
  Time("Backpropagate", options.repetitions, [&] {
    const FieldGradient result = renderer->Backpropagate(view, gradient, parts);
    double sum = 0;
    for (float g : result.density) sum += double(g);
    fmt::print("sum of density gradients {:.6g}\n", sum);
  });
}

}  // namespace
}  // namespace tetrec

int main(int argc, char** argv) {
  tetrec::SizeOptions options;
  CLI::App app("Time and memory for one image and its gradients on a mesh of any size");
  app.add_option("--tets", options.tets, "approximate number of tets")->capture_default_str();
  app.add_option("--width", options.width)->capture_default_str();
  app.add_option("--height", options.height)->capture_default_str();
  app.add_option("--removed", options.removed, "share of the tets to remove again")
      ->check(CLI::Range(0.0, 0.99));
  app.add_option("--repetitions", options.repetitions, "runs, of which the fastest counts");
  app.add_flag("--ball", options.ball, "fill a ball instead of a cube");
  app.add_flag("--positions", options.positions, "include gradients of positions");
  AddWordOption(app, "--renderer", options.renderer.kind, "");
  AddWordOption(app, "--order", options.renderer.order, "");
  uint64_t fragment_memory_mib = options.renderer.fragment_memory >> 20;
  app.add_option("--fragment-memory", fragment_memory_mib, "[MiB]")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  options.renderer.fragment_memory = fragment_memory_mib << 20;
  try {
    tetrec::Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_size: {}\n", error.what());
    return 1;
  }
}
