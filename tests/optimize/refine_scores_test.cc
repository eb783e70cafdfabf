#include "optimize/refine_scores.h"

#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace tetrec {
namespace {

// A run whose field is right but for the colours where x > 0.4.
struct WrongRun : SmallRun {
  explicit WrongRun(RefineScore score) : SmallRun(Options(score)) {
    RadianceField box = WavyBox(0.4);
    for (size_t v = 0; v < box.color_srgb.size(); ++v) {
      if (box.mesh.positions[v].x > 0.4f) box.color_srgb[v] = glm::vec3(0.0f, 1.0f, 0.0f);
    }
    const FieldState state = StateOf(box);
    field.Put(std::move(box.mesh), state);
  }
  static OptimizeOptions Options(RefineScore score) {
    OptimizeOptions options = SmallRunOptions();
    options.score = score;
    options.background = BackgroundChoice::kScene;
    return options;
  }
  RefineScores Look() { return LookAtScores(*renderer, pictures.set(), batches, options, 7); }
};

TEST(RefineScores, OfEveryKindAreLargeWhereTheFieldIsWrong) {
  for (const RefineScore score :
       {RefineScore::kAuto, RefineScore::kResidual, RefineScore::kColor, RefineScore::kPosition,
        RefineScore::kVariance, RefineScore::kGain}) {
    SCOPED_TRACE(int(score));
    WrongRun run(score);
    RefineScores scores = run.Look();
    const TetMesh& mesh = run.field.mesh();
    const bool of_vertices = score == RefineScore::kColor || score == RefineScore::kPosition;
    const bool of_both = score == RefineScore::kGain;
    ASSERT_EQ(scores.of_vertices.size(), of_vertices || of_both ? mesh.positions.size() : 0u);
    ASSERT_EQ(scores.of_tets.size(), of_vertices ? 0u : mesh.tets.size());
    EXPECT_EQ(scores.visible_of_tets.size(), mesh.tets.size());
    EXPECT_GT(scores.squared_error, 0.0);
    CompleteScores(mesh, scores);
    double wrong = 0, all = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      EXPECT_GE(scores.of_vertices[v], 0.0f);
      all += scores.of_vertices[v];
      if (mesh.positions[v].x > 0.1f) wrong += scores.of_vertices[v];
    }
    EXPECT_GT(wrong, 0.9 * all);
  }
}

TEST(RefineScores, LeaveNoGradientBehind) {
  WrongRun run(RefineScore::kColor);
  const FieldState before = run.field.ReadState();
  run.Look();
  const std::vector<double> left = run.renderer->TakeGradients().values;
  EXPECT_TRUE(std::all_of(left.begin(), left.end(), [](double value) { return value == 0.0; }));
  EXPECT_EQ(run.field.ReadState().parameters, before.parameters);
}

// The sum of a look's scores does not depend on what waited in the renderer.
TEST(RefineScores, AreThoseOfTheLookAlone) {
  WrongRun quiet(RefineScore::kColor), busy(RefineScore::kColor);
  TrainingBatch batch = busy.batches.Draw(1);
  busy.renderer->Forward(batch);
  busy.renderer->Backward(GradientParts::kColorDensityPosition);
  EXPECT_EQ(busy.Look().of_vertices, quiet.Look().of_vertices);
}

TEST(CompleteScores, SharesScoresBetweenTetsAndVertices) {
  const TetMesh mesh = WavyBox(0.4).mesh;
  RefineScores scores{.of_tets = std::vector<float>(mesh.tets.size(), 2.0f), .of_vertices = {}};
  CompleteScores(mesh, scores);
  const auto sum = [](const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  EXPECT_NEAR(sum(scores.of_vertices), 2.0 * double(mesh.tets.size()), 1e-2);
  scores.of_tets.clear();
  CompleteScores(mesh, scores);
  EXPECT_NEAR(sum(scores.of_tets), sum(scores.of_vertices), 1e-2);
}

}  // namespace
}  // namespace tetrec
