// The first tetrahedral mesh of a scene, with the field that optimisation starts from.
#pragma once

#include "core/stage.h"
#include "core/words.h"
#include "start/dense_start.h"
#include "start/initial_field.h"
#include "start/start_points.h"
#include "stereo/stereo.h"

#include <cstdint>
#include <optional>

namespace tetrec {

// Where the first vertices come from.
enum class StartKind {
  kDense,   // points of depth maps and layers around them, a fill and a far shell, Delaunay
  kPoints,  // the sparse points, a fill and a far shell, Delaunay
  kCarve,   // what the alpha masks leave of the subject's box, Delaunay
  kGrid,    // a jittered grid in the subject's box, Delaunay
  kTetgen,  // the subject's box, meshed by TetGen
};
template <>
inline constexpr auto kWords<StartKind> =
    std::to_array<Word<StartKind>>({{StartKind::kDense, "dense"},
                                    {StartKind::kPoints, "points"},
                                    {StartKind::kCarve, "carve"},
                                    {StartKind::kGrid, "grid"},
                                    {StartKind::kTetgen, "tetgen"}});

struct TetrahedralizeOptions {
  // None: with alpha kPoints if the scene has sparse points, otherwise kCarve; without alpha
  // kDense, or kPoints, or kGrid, the first that is possible.
  std::optional<StartKind> start;
  uint64_t seed = 1;   // of jitter and random vertices
  int resolution = 0;  // cells along the longest side; 0: 64 to carve, 32 for a grid, 24 for TetGen
  PointFilter filter;  // kPoints, kDense
  PointStartOptions shell;                            // kPoints, kDense
  StereoOptions stereo{.fusion = {.max_points = 0}};  // kDense; 0 points: by the photos' pixels
  DenseStartOptions dense;                            // kDense
  CarveStartOptions carve;                            // kCarve
  InitialFieldOptions field;

  void Check() const;  // throws UsageError naming the option and its value
};

// Reads the scene in the stage's input "scene"; writes mesh.tet and field.tetf, and
// with kDense depth/ (stereo_depth.h) and depth/points.ply.
void RunTetrahedralize(const TetrahedralizeOptions& options, Stage& stage);

}  // namespace tetrec
