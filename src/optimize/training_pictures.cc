// The training pictures of a run: where their cameras are, and which of their pixels are learned.
#include "optimize/training_pictures.h"

#include "core/random.h"

#include <algorithm>

namespace tetrec {

TrainingPictures::TrainingPictures(const OptimizeOptions& options, TrainingSet set,
                                   const glm::vec3& background_srgb, TrainingRenderer& renderer)
    : options_(options),
      renderer_(renderer),
      set_(std::move(set)),
      given_views_(set_.views),
      judging_(ChooseJudgingSet(set_, options.seed)),
      background_srgb_(background_srgb) {}

void TrainingPictures::PlaceCameras(std::span<const CorrectedPose> poses, double progress) {
  set_.views = given_views_;
  for (size_t i = 0; i < poses.size(); ++i) set_.views[i].cam_from_world = poses[i].cam_from_world;
  ChooseLearned(!KeepsJudging(progress));
}

void TrainingPictures::EndJudgingIfDue(double progress) {
  if (!learns_all_ && !KeepsJudging(progress)) ChooseLearned(true);
}

Judgement TrainingPictures::JudgeField(std::optional<int> samples) {
  renderer_.SetTargets(set_.views, set_.targets);
  const Judgement judgement =
      Judge(renderer_, judging_, background_srgb_, samples.value_or(samples_));
  ChooseLearned(learns_all_);
  return judgement;
}

void TrainingPictures::GatherExposuresOfWholeViews(uint64_t iteration) {
  if (learns_all_ || judging_.spare_blocks.empty()) return;
  constexpr size_t kMostBlocks = 512, kMostOfView = 64;
  const auto views = size_t(std::ranges::count(judging_.is_whole, 1));
  const size_t of_view = std::clamp<size_t>(kMostBlocks / views, 1, kMostOfView);
  Random random(options_.seed ^ 0xE4B0ull, iteration);
  std::vector<RayBlock> blocks;
  const std::span<const RayBlock> spare = judging_.spare_blocks;
  for (size_t begin = 0, end = 0; begin < spare.size(); begin = end) {
    while (end < spare.size() && spare[end].view == spare[begin].view) ++end;
    for (size_t i = 0; i < of_view; ++i) {
      blocks.push_back(spare[begin + random.Below(uint32_t(end - begin))]);
    }
  }
  TrainingBatch batch;
  batch.blocks = blocks;
  batch.background_srgb = background_srgb_;
  batch.sums_exposures = true;
  renderer_.Forward(batch);
}

// In the last part of a run all is learned. A few tiny pictures may have no tile that judges.
bool TrainingPictures::KeepsJudging(double progress) const {
  return options_.judging_pictures == JudgingPictures::kKept && !judging_.blocks.empty() &&
         progress < options_.schedule.last_judging;
}

void TrainingPictures::ChooseLearned(bool all) {
  learns_all_ = all;
  ListBlocks(set_, learns_all_ ? std::vector<uint8_t>() : judging_.is_whole);
  renderer_.SetTargets(set_.views, learns_all_ ? set_.targets : WithoutJudging());
}

}  // namespace tetrec
