// The training pictures of a run: where their cameras are, and which of their pixels are learned.
#include "optimize/training_pictures.h"

#include "core/random.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrec {
namespace {

constexpr size_t kBlocksOfView = 128;  // that show how well a view fits

// `blocks`: view by view.
size_t CountViews(std::span<const RayBlock> blocks) {
  size_t count = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    count += i == 0 || blocks[i].view != blocks[i - 1].view;
  }
  return count;
}

}  // namespace

TrainingPictures::TrainingPictures(const OptimizeOptions& options, TrainingSet set,
                                   const glm::vec3& background_srgb, TrainingRenderer& renderer)
    : options_(options),
      renderer_(renderer),
      set_(std::move(set)),
      given_views_(set_.views),
      all_judging_(ChooseJudgingSet(set_, options.seed)),
      judging_(all_judging_),
      background_srgb_(background_srgb) {}

void TrainingPictures::PlaceCameras(std::span<const CorrectedPose> poses, double progress) {
  set_.views = given_views_;
  for (size_t i = 0; i < poses.size(); ++i) set_.views[i].cam_from_world = poses[i].cam_from_world;
  ChooseLearned(!KeepsJudging(progress));
}

void TrainingPictures::LeaveOut(std::span<const uint8_t> views) {
  left_out_.assign(views.begin(), views.end());
  judging_ = Without(all_judging_, left_out_);
  // Without steps that draw them, their exposures would become neutral, and they would never fit
  // again.
  for (const RayBlock& block : SampleViews(set_, kBlocksOfView).blocks) {
    if (!left_out_.empty() && left_out_[block.view]) judging_.spare_blocks.push_back(block);
  }
  ChooseLearned(learns_all_);
}

void TrainingPictures::EndJudgingIfDue(double progress) {
  if (!learns_all_ && !KeepsJudging(progress)) ChooseLearned(true);
}

Judgement TrainingPictures::JudgeField(std::optional<int> samples) {
  renderer_.SetTargets(set_.views, set_.targets);
  const Judgement judgement =
      Judge(renderer_, judging_, background_srgb_, samples.value_or(samples_));
  ShowWhatIsLearned();
  return judgement;
}

std::vector<ErrorSum> TrainingPictures::ErrorsOfViews() {
  const JudgingSet sample = SampleViews(set_, kBlocksOfView);
  renderer_.SetTargets(set_.views, set_.targets);
  const Judgement judgement =
      Judge(renderer_, sample, background_srgb_, samples_, std::numeric_limits<size_t>::max());
  ShowWhatIsLearned();
  std::vector<ErrorSum> errors(set_.views.size());
  size_t judged = 0;
  for (size_t i = 0; i < sample.blocks.size(); ++i) {
    const uint32_t view = sample.blocks[i].view;
    if (i == 0 || view != sample.blocks[i - 1].view) errors[view] = judgement.views[judged++];
  }
  for (size_t view = 0; view < errors.size(); ++view) {
    if (all_judging_.is_whole[view]) errors[view] = {};
  }
  return errors;
}

void TrainingPictures::GatherExposuresOfWholeViews(uint64_t iteration) {
  if (learns_all_ || judging_.spare_blocks.empty()) return;
  constexpr size_t kMostBlocks = 512, kMostOfView = 64;
  const size_t views = CountViews(judging_.spare_blocks);
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
  // Colours that depend on the view take memory for each view of a batch.
  const size_t of_batch = of_view * renderer_.Pace().views_per_batch;
  for (size_t first = 0; first < blocks.size(); first += of_batch) {
    TrainingBatch batch;
    batch.blocks = std::span(blocks).subspan(first, std::min(of_batch, blocks.size() - first));
    batch.background_srgb = background_srgb_;
    batch.sums_exposures = true;
    renderer_.Forward(batch);
  }
}

// In the last part of a run all is learned. A few tiny pictures may have no tile that judges.
bool TrainingPictures::KeepsJudging(double progress) const {
  return options_.judging_pictures == JudgingPictures::kKept && !judging_.blocks.empty() &&
         progress < options_.schedule.last_judging;
}

void TrainingPictures::ChooseLearned(bool all) {
  learns_all_ = all;
  std::vector<uint8_t> not_learned = left_out_;
  if (!learns_all_) {
    not_learned.resize(set_.views.size(), 0);
    for (size_t view = 0; view < not_learned.size(); ++view) {
      not_learned[view] |= judging_.is_whole[view];
    }
  }
  // Listing blocks looks at every pixel.
  if (not_learned != not_learned_) {
    ListBlocks(set_, not_learned);
    not_learned_ = std::move(not_learned);
  }
  ShowWhatIsLearned();
}

void TrainingPictures::ShowWhatIsLearned() {
  renderer_.SetTargets(set_.views, learns_all_ ? set_.targets : WithoutJudging());
}

}  // namespace tetrec
