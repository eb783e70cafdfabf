#include "optimize/optimize_options.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <functional>

namespace tetrec {
namespace {

OptimizeOptions With(const std::function<void(OptimizeOptions&)>& change) {
  OptimizeOptions options;
  change(options);
  return options;
}

TEST(OptimizeOptions, AreAcceptedWhereTheyAgree) {
  EXPECT_NO_THROW(OptimizeOptions().Check());
  for (const RendererKind kind : {RendererKind::kMarch, RendererKind::kReference}) {
    EXPECT_NO_THROW(With([kind](OptimizeOptions& o) {
                      o.renderer.kind = kind;
                      o.fine_rays = FineRaysChoice::kOn;
                    }).Check());
  }
}

TEST(OptimizeOptions, AreRefusedWhereTheyContradictEachOther) {
  const std::vector<OptimizeOptions> refused = {
      With([](OptimizeOptions& o) {
        o.time_limit_s = 0;
        o.judging_pictures = JudgingPictures::kLearned;
      }),
      With([](OptimizeOptions& o) { o.renderer.deterministic = true; }),
      With([](OptimizeOptions& o) { o.budget_tets = o.budget_mb = 1000; }),
      With([](OptimizeOptions& o) { o.budget_mb = 2000000000; }),
      With([](OptimizeOptions& o) { o.budget = BudgetChoice::kFull; }),
      With([](OptimizeOptions& o) { o.rays_per_step = 0; }),
      With([](OptimizeOptions& o) { o.rays_per_step = 1'048'577; }),
      With([](OptimizeOptions& o) {
        o.density = DensityForm::kSigned;
        o.storage = FieldStorage::kCell;
      }),
      With([](OptimizeOptions& o) {
        o.score = RefineScore::kGain;
        o.storage = FieldStorage::kCell;
      }),
      With([](OptimizeOptions& o) {
        o.fine_rays = FineRaysChoice::kOn;
        o.loss.dssim = 0.2;
      }),
      With([](OptimizeOptions& o) {
        o.fine_rays = FineRaysChoice::kOn;
        o.renderer.kind = RendererKind::kPpll;
      }),
      With([](OptimizeOptions& o) {
        o.fine_rays = FineRaysChoice::kOn;
        o.renderer.kind = RendererKind::kProjection;
      }),
  };
  for (const OptimizeOptions& options : refused) EXPECT_THROW(options.Check(), UsageError);
  With([](OptimizeOptions& o) { o.rays_per_step = 1'048'576; }).Check();
}

}  // namespace
}  // namespace tetrec
