// The state of a run on disk, from which a stopped or killed run continues.
#pragma once

#include "field/field_state.h"
#include "mesh/tet_mesh.h"
#include "optimize/camera_poses.h"
#include "optimize/coarsening.h"
#include "optimize/convergence.h"
#include "optimize/exposure.h"
#include "optimize/harmonics.h"
#include "optimize/optimize_options.h"
#include "optimize/refinement_rounds.h"
#include "optimize/stray_photos.h"
#include "optimize/vertex_motion.h"
#include "render/device_pace.h"
#include "render/training_renderer.h"

#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// In the folder of the run, until it is done.
inline constexpr const char* kCheckpointFile = "checkpoint.bin";

struct Checkpoint {
  uint64_t iteration = 0;  // steps done
  double seconds = 0;      // of optimisation
  uint64_t rays = 0;
  DevicePace pace;            // of the renderer: the schedule follows from it
  double share_of_rates = 1;  // TrainingSteps
  RoundsState rounds;
  CoarseningState coarsening;
  ConvergenceState convergence;
  uint64_t metrics_bytes = 0;  // length of metrics.csv at that time
  HarmonicsState harmonics;
  TrialState fine_rays = TrialState::kNotTried;
  TetMesh mesh;
  FieldState state;
  std::vector<RowRates> row_rates;  // of the state
  MotionState motion;
  ExposureState exposure;
  PoseState poses;
  StrayState stray;
};

// Own format, little endian: "TETRECKH", u64 iteration, f64 seconds, u64 rays, of the pace u64
// rays per step, u64 views per batch, f64 speed and u64 steps per motion, u32 rounds and u32 ended
// (0 or 1), f64 best PSNR, u64 judging views and for each f64 squares and rays, u64 growth steps
// and their fields, 8 bytes each (GrowthStep), of the coarsening u32 ended and u32 has failed (each
// 0 or 1), f64 kept share, u64 finest vertices, u64 views and for each f64 squares and rays, of the
// convergence u64 x 3 and f64 (ConvergenceState), u64 metrics bytes, harmonics unlocked, judged and
// closed u32 x 3, u32 fine rays (0 not tried, 1 not used, 2 used), u64
// V, u64 T, the layout (AppendLayout), positions f32 x 3 V, tets and neighbours u32 x 4 T each,
// then parameters, first moments and second moments, each f32 x rows x their number (FieldState),
// and RowRates, f32 x 3 rows; then f64 share of the rates; of the vertices' motion u64 motions, u64
// x 3 counts (MotionCounts) and u64 M, 0 or V, first and second moments f32 x 3 M each, sizes and
// room f32 x M each; then u64 exposures E, for each gains and offsets, f64 x 3 each, and for each
// the sums of its three channels, f64 x 5 each (GainOffsetSums); then u32 sweeps over the cameras,
// u64 poses P, and for each cam_from_world, f64 x 9 of the rotation by columns and x 3 of the
// translation, and the depth, f64; then u32 looks for stray photos, u64 N, N bytes, 1 for a photo
// that is left out and 0 for others, and N ratios of errors, f32; last the SHA-256 of all before
// it, 64 hexadecimal digits. Written by rename.
void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);
// Throws DataError naming the file and the remedy if it is damaged, truncated or inconsistent.
Checkpoint ReadCheckpoint(const std::filesystem::path& path);
// Parses what precedes the checksum.
Checkpoint ParseCheckpoint(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
