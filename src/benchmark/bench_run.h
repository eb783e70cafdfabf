// Measures renderers, orders and integrals on the same meshes and views: time, memory, and errors
// relative to the reference renderer in double precision.
#pragma once

#include "benchmark/bench_scene.h"
#include "render/renderer.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

inline const std::vector<uint64_t> kTetsOfBall = {10'000, 100'000, 1'000'000};

struct BenchOptions {
  std::vector<std::string> renderers = {"march", "ppll", "projection"};
  std::vector<std::string> orders = {"exact", "centroid"};  // of projection
  std::vector<std::string> integrals = {"mean",    "split:2",  "split:4",
                                        "split:8", "split:16", "exact"};
  // Every renderer with every integral; otherwise the first renderer with all integrals and the
  // others with the last.
  bool all_pairs = false;
  // Sizes of the meshes. If empty: the field's own mesh, or kTetsOfBall without a field.
  std::vector<uint64_t> tets;
  std::vector<int> sizes = {128, 256, 512};  // [px] per side
  int repeat = 5;
  int error_size = 64;        // [px] per side of the images that errors are measured on
  double case_seconds = 20;   // [s] a case that has taken this long is not repeated
  double longest_turn = 300;  // [s] a case that might take longer for one turn is skipped
  uint64_t seed = 1;          // of meshes and gradients
  // Storage of the attributes; by default that of the field, or kVertex without a field.
  std::optional<FieldStorage> storage;
  RendererOptions renderer;  // device, memory, early stop, deterministic

  void Check() const;  // throws UsageError naming the option and its value
};

// A combination of options that is measured.
struct BenchVariant {
  std::string renderer, order, integral;  // order: empty if the renderer has none
  RendererOptions options;
};

// True if any of the renderers requires a Vulkan device.
bool UsesVulkan(const BenchOptions& options);

std::vector<BenchVariant> VariantsOf(const BenchOptions& options);

// Milliseconds, one value per repetition.
struct BenchTime {
  std::vector<double> wall, cpu;
};

// Errors relative to the reference renderer in double precision with the exact integral, both
// without early stop, on images of error_size with full scale 1.
struct BenchErrors {
  double largest = 0, rms = 0;                  // of colour over black and over white
  double color = 0, density = 0, position = 0;  // of gradients, relative in the norm
};

struct BenchRow {
  BenchVariant variant;
  uint64_t tets = 0, vertices = 0;
  FieldStorage storage = FieldStorage::kVertex;
  int size = 0;     // [px] per side
  double rays = 0;  // per image
  // Mean number of tets over all rays of the views, early stop and misses included; 0: not counted.
  double steps_per_ray = 0;
  std::optional<double> skipped_seconds;  // not measured: a turn might have taken this long
  // Forward; forward and backward for colour and density; the same with positions too.
  BenchTime forward, backward, positions;
  uint64_t device_bytes = 0;  // peak, over this and smaller images
  BenchErrors errors;         // of the mesh, the same for all sizes
};

struct BenchResult {
  std::string device, scene;  // for headings
  BenchOptions options;
  std::vector<BenchRow> rows;
};

// Measures `field` at its `views`, or the ball in the cube if `field` is null. A request to stop
// ends it with the sizes that are done; throws Interrupted if there are none.
BenchResult RunBench(const BenchOptions& options, const RadianceField* field,
                     const std::vector<RenderView>& views);
// Measures the field in a folder of tetrec-optimize at the views of its scene, or the ball in the
// cube if the path is empty.
BenchResult RunBench(const BenchOptions& options, const std::filesystem::path& field_folder);

}  // namespace tetrec
