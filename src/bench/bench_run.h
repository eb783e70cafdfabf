// Measures renderers, orders and integrals on the same meshes and views: time, memory, errors
// against the reference in double.
#pragma once

#include "bench/bench_scene.h"
#include "render/renderer.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct BenchOptions {
  std::vector<std::string> renderers = {"march", "ppll", "projection"};
  std::vector<std::string> orders = {"exact", "centroid"};  // of projection
  std::vector<std::string> integrals = {"mean",    "split:2",  "split:4",
                                        "split:8", "split:16", "exact"};
  // Every renderer with every integral; else the first with all of them, the others with the last.
  bool all_pairs = false;
  std::vector<uint64_t> tets;
  std::vector<int> sizes = {128, 256, 512};  // [px] a side
  int repeat = 5;
  int error_size = 64;        // [px] a side of the pictures that errors are measured on
  double case_seconds = 20;   // a case that has taken this long is not repeated
  double longest_turn = 300;  // [s] a case that may take longer for one turn is left out
  uint64_t seed = 1;          // of meshes and gradients
  // Of the meshes' attributes; none: the field's own, without a field of vertices.
  std::optional<FieldStorage> storage;
  RendererOptions renderer;  // device, memory, early stop, deterministic

  void Check() const;  // throws UsageError naming the option and its value
};

// What is measured.
struct BenchVariant {
  std::string renderer, order, integral;  // order: empty where there is none
  RendererOptions options;
};

// Whether any of the renderers needs a Vulkan device.
bool UsesVulkan(const BenchOptions& options);

std::vector<BenchVariant> VariantsOf(const BenchOptions& options);

// Milliseconds of the repetitions.
struct BenchTime {
  std::vector<double> wall, cpu;
};

// Against the reference in double with the exact integral, neither stopping early, on pictures of
// error_size, full scale 1.
struct BenchErrors {
  double largest = 0, rms = 0;                  // of colour over black and over white
  double color = 0, density = 0, position = 0;  // relative, of gradients, in the norm
};

struct BenchRow {
  BenchVariant variant;
  uint64_t tets = 0, vertices = 0;
  FieldStorage storage = FieldStorage::kVertex;
  int size = 0;     // [px] a side
  double rays = 0;  // of a picture
  // Tets, over the views of the turns, early stop and misses included; 0: not counted.
  double steps_per_ray = 0;
  std::optional<double> skipped_seconds;  // a turn may have taken so long: nothing was measured
  // Forward; forward and backward by colour and density; and by positions too.
  BenchTime forward, backward, positions;
  uint64_t device_bytes = 0;  // most so far, this and smaller pictures
  BenchErrors errors;         // of the mesh, the same for all sizes
};

struct BenchResult {
  std::string device, scene;  // as a heading says them
  BenchOptions options;
  std::vector<BenchRow> rows;
};

// `field` and its `views`, or nothing for the ball in the cube. Meshes are made to
// BenchOptions::tets; none there: the field's own.
BenchResult RunBench(const BenchOptions& options, const RadianceField* field,
                     const std::vector<RenderView>& views);

}  // namespace tetrec
