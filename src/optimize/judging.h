// The judging pictures: parts of the training pictures that are kept from gradients and from
// refinement for most of a run, so that its decisions need no held-out view.
#pragma once

#include "optimize/schedule.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

struct JudgingSet {
  std::vector<uint8_t> is_whole;       // per view: none of it is learned
  std::vector<RayBlock> blocks;        // aligned blocks that judge, view by view
  std::vector<uint8_t> pixels;         // of each block: those that count, at least one
  std::vector<RayBlock> spare_blocks;  // of whole views, view by view: those that do not judge
};

// If there are kLeastViewsToJudge training views, one in kViewsPerJudge is kept whole; every second
// of its tiles of 16 x 16 pixels judges, and its camera is found by the others. Of the other views
// one tile in kTilesPerJudge is kept, chosen by the seed.
inline constexpr size_t kLeastViewsToJudge = 24, kViewsPerJudge = 16;
inline constexpr uint32_t kTilesPerJudge = 32;
JudgingSet ChooseJudgingSet(const TrainingSet& set, uint64_t seed);

// `blocks_per_view` blocks of each view, one drawn at random from each of as many equal stretches;
// all of them if there are fewer. Blocks that masks hide entirely do not count.
JudgingSet SampleViews(const TrainingSet& set, size_t blocks_per_view);

// The judging set without the views whose flags are set, or all of it if there are no flags.
JudgingSet Without(const JudgingSet& judging, std::span<const uint8_t> left_out);

// The targets with kNotJudgedTarget where pixels judge. The blocks of whole views are not to be
// learned from either.
std::vector<TargetImage> TargetsToLearn(const TrainingSet& set, const JudgingSet& judging);

// The squared error of some rays, of display sRGB in [0, 1], averaged over the channels. Rays
// through pixels that masks exclude do not count.
struct ErrorSum {
  double squares = 0, rays = 0;

  void Add(const ErrorSum& other) { squares += other.squares, rays += other.rays; }
  double Psnr() const;  // 0 without rays [dB]
  bool operator==(const ErrorSum&) const = default;
};

// The PSNR of the mean squared error [dB] of whole views and of tiles, and of all judging pixels
// with its standard error over the views.
struct Judgement {
  double psnr = 0, standard_error = 0;
  double views_psnr = 0, tiles_psnr = 0;  // 0 if there are none
  std::vector<ErrorSum> views;            // each view that judges
};

// The renderer's targets are those of the set. `background_srgb`: behind field and targets.
// `samples`: TrainingBatch::samples. If there are more than `most_pixels` judging pixels, only
// every n-th block of each view is rendered: the errors of neighbours are alike.
inline constexpr size_t kMostJudgedPixels = size_t{1} << 17;
Judgement Judge(TrainingRenderer& renderer, const JudgingSet& judging,
                const glm::vec3& background_srgb, int samples = 1,
                size_t most_pixels = kMostJudgedPixels);

// Returns true if the pictures are matched (ScheduleOptions) even at one standard error below their
// PSNR.
inline bool IsMatched(const Judgement& judgement, const ScheduleOptions& schedule) {
  return judgement.psnr - judgement.standard_error >= schedule.matched_psnr;
}

// What the judging pictures gained [dB], and its standard error over the views. It is far smaller
// than that of either PSNR, because views that are hard are hard both times.
struct JudgedGain {
  double gain = 0, standard_error = 0;
};

// From `before` to `after`, of the same views. Without views, or of other ones, nothing is known:
// 0.
JudgedGain GainBetween(std::span<const ErrorSum> before, std::span<const ErrorSum> after);

}  // namespace tetrec
