#include "optimize/training_history.h"

#include "render/create_renderer.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(StepAverages, AreMeansOfWhatWasCollected) {
  StepAverages averages;
  EXPECT_TRUE(averages.IsEmpty());
  averages.Add({});  // the first step of a renderer that works ahead
  EXPECT_TRUE(averages.IsEmpty());
  averages.Add({.loss = 0.1, .squared_error = 0.005});
  averages.Add({.loss = 0.3, .squared_error = 0.015});
  EXPECT_DOUBLE_EQ(averages.Loss(), 0.2);
  EXPECT_DOUBLE_EQ(averages.Psnr(), 20.0);
}

TEST(TrainingHistory, HasARowForEachTwoPercentAndOneForTheEnd) {
  const ScratchFolder folder;
  const auto renderer = CreateRenderer({.kind = RendererKind::kReference});
  const Scene scene;
  const WatchedViews nothing{*renderer, folder.path(), scene, {}};
  TrainingHistory history(folder / kTrainingLogFile, 0, nothing, true);
  RunFigures now;
  for (; now.iteration < 1000; ++now.iteration) {
    now.progress = double(now.iteration) / 1000;
    history.Add({.loss = 0.5, .squared_error = now.progress < 0.5 ? 0.1 : 0.01});
    history.Record(now);
  }
  EXPECT_EQ(history.End(now), std::nullopt);
  const std::vector<TrainingRow> rows = ReadTrainingLog(folder / kTrainingLogFile);
  ASSERT_EQ(rows.size(), 51u);
  EXPECT_EQ(rows[1].iteration, 20u);
  EXPECT_NEAR(rows[10].train_psnr.value(), 10.0, 1e-4);
  EXPECT_NEAR(rows[40].train_psnr.value(), 20.0, 1e-4);
  EXPECT_EQ(rows[50].phase, "end");
  EXPECT_EQ(rows[50].iteration, 1000u);
  EXPECT_FALSE(rows[50].heldout_psnr);
  EXPECT_EQ(history.bytes(), std::filesystem::file_size(folder / kTrainingLogFile));
}

}  // namespace
}  // namespace tetrec
