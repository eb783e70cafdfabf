// The training pictures of a run: where their cameras are, and which of their pixels are learned.
#pragma once

#include "optimize/camera_poses.h"
#include "optimize/judging.h"
#include "optimize/optimize_options.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace tetrec {

// Keeps the renderer's targets and the blocks that batches draw from in agreement. `progress` is
// that of the run, in [0, 1]: it decides whether the judging pictures are kept from learning.
class TrainingPictures {
 public:
  // `set` lists the blocks of all views. `background_srgb`: behind field and pictures when they
  // judge. The renderer has no targets before the first call of PlaceCameras.
  TrainingPictures(const OptimizeOptions& options, TrainingSet set,
                   const glm::vec3& background_srgb, TrainingRenderer& renderer);

  // Its cameras are the corrected ones, its blocks those that may be learned.
  const TrainingSet& set() const { return set_; }
  // With the scene's own cameras.
  const std::vector<RenderView>& given_views() const { return given_views_; }
  const glm::vec3& background_srgb() const { return background_srgb_; }
  // True if the judging pictures are learned, too: then nothing judges.
  bool learns_all() const { return learns_all_; }
  // False if the pictures are so small that none of their parts can be kept to judge.
  bool can_judge() const { return !judging_.blocks.empty(); }
  // The pictures without their judging pixels, whether these are learned or not.
  std::vector<TargetImage> WithoutJudging() const { return TargetsToLearn(set_, judging_); }

  // One pose per view, or none for the scene's own.
  void PlaceCameras(std::span<const CorrectedPose> poses, double progress);
  // From now on, views whose flags are set are neither learned nor used to judge. Without flags, no
  // view is left out.
  void LeaveOut(std::span<const uint8_t> views);
  // Lets the judging pictures be learned if the time of judging is over.
  void EndJudgingIfDue(double progress);
  // What the judging pictures say of the renderer's field. They are kept from learning, or learned,
  // as before, however late it is. `samples`: TrainingBatch::samples, by default those of JudgeBy.
  Judgement JudgeField(std::optional<int> samples = {});
  // The errors of the renderer's field in a sample of each view that is learned or left out; no
  // rays for those that are kept whole to judge: unseen, they have larger errors than others.
  std::vector<ErrorSum> ErrorsOfViews();
  // Adds samples of the whole judging views, and of those that are left out, to the sums from which
  // exposures are fitted. No step draws these views, so that they would be judged at a neutral
  // exposure otherwise. The samples are pixels that do not judge; `iteration` determines which.
  void GatherExposuresOfWholeViews(uint64_t iteration);
  // From now on fields are judged by so many samples. Judgements by different ones cannot be
  // compared.
  void JudgeBy(int samples) { samples_ = samples; }

 private:
  bool KeepsJudging(double progress) const;
  void ChooseLearned(bool all);
  void ShowWhatIsLearned();

  const OptimizeOptions& options_;
  TrainingRenderer& renderer_;
  TrainingSet set_;
  std::vector<RenderView> given_views_;
  JudgingSet all_judging_, judging_;  // of all views, and without those that are left out
  std::vector<uint8_t> left_out_;     // per view; empty: none
  std::vector<uint8_t> not_learned_;  // per view: its blocks are not in set_; empty: all are
  glm::vec3 background_srgb_;
  int samples_ = 1;
  bool learns_all_ = true;
};

}  // namespace tetrec
