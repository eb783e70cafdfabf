#include "optimize/weak_colors.h"

#include "mesh/mesh_edges.h"
#include "optimize/small_run.h"
#include "render/seen_colors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace tetrec {
namespace {

// The sum over the vertices, each by pictures of a field in which only its colour differs.
double EvidenceByPictures(SmallRun& run, const std::vector<size_t>& vertices) {
  constexpr float kChange = 0.25f;
  double evidence = 0;
  for (const RenderView& view : run.pictures.set().views) {
    RadianceField box = WavyBox(0.4);
    run.renderer->SetField(box);
    const RenderedImage before = run.renderer->Render(view, 1);
    for (const size_t vertex : vertices) {
      box.color_srgb[vertex].y += kChange;
      run.renderer->SetField(box);
      const RenderedImage after = run.renderer->Render(view, 1);
      box.color_srgb[vertex].y -= kChange;
      for (size_t i = 0; i < before.color_srgb.size(); ++i) {
        const double share = double(after.color_srgb[i].y - before.color_srgb[i].y) / kChange;
        evidence += share * share;
      }
    }
  }
  return evidence;
}

// What photos and field differ by is rounding, whose signs are random.
TEST(LookAtColorEvidence, IsTheSumOfTheSquaredSharesOfAColour) {
  SmallRun run;
  run.pictures.EndJudgingIfDue(1.0);
  const std::vector<float> evidence =
      LookAtColorEvidence(*run.renderer, run.pictures.set(), run.batches, 3);
  ASSERT_EQ(evidence.size(), run.field.mesh().positions.size());
  double looked = 0;
  std::vector<size_t> in_front;
  for (size_t vertex = 0; vertex < evidence.size(); ++vertex) {
    const glm::vec3 place = run.field.mesh().positions[vertex];
    const bool is_in_front = place.x > 0.9f && std::abs(place.y) < 0.6f && std::abs(place.z) < 0.4f;
    if (glm::length(place) < 0.1f) {
      EXPECT_LT(evidence[vertex], 1e-4);  // amid what is opaque
    }
    if (!is_in_front) continue;
    looked += evidence[vertex];
    in_front.push_back(vertex);
  }
  const double by_pictures = EvidenceByPictures(run, in_front);
  EXPECT_GT(by_pictures, 10.0);
  // Neighbouring rays of a part share vertices, and some of their signs.
  EXPECT_GT(looked, 0.7 * by_pictures);
  EXPECT_LT(looked, 3.0 * by_pictures);
}

// Batches of few views are smaller, but all pixels are looked at.
TEST(LookAtColorEvidence, IsTheSameByBatchesOfFewViews) {
  OptimizeOptions options = SmallRunOptions();
  options.renderer.pace = {.views_per_batch = 1};
  SmallRun run(options);
  run.pictures.EndJudgingIfDue(1.0);
  const auto evidence = [&] {
    return LookAtColorEvidence(*run.renderer, run.pictures.set(), run.batches, 3);
  };
  const std::vector<float> of_all = evidence();
  run.batches.UseFewViews(true);
  const std::vector<float> of_few = evidence();
  EXPECT_GT(*std::ranges::max_element(of_few), 1.0f);
  for (size_t vertex = 0; vertex < of_all.size(); ++vertex) {
    EXPECT_NEAR(of_few[vertex], of_all[vertex], 1e-4f * of_all[vertex] + 1e-9f);
  }
}

class SmoothWeakColorsTest : public ::testing::Test {
 protected:
  static constexpr size_t kVertex = 364;  // any vertex

  SmoothWeakColorsTest() {
    state_ = WithHarmonics(StateOf(box_), 1);
    components_ = size_t(state_.layout.Components());
    evidence_.assign(box_.mesh.positions.size(), 5.0f);
    Color(kVertex) = 3.0f;
    Harmonics(kVertex) = 3.0f;
    for (const glm::uvec2& edge : EdgesOf(box_.mesh).ends) {
      if (edge.x == kVertex) near_.insert(edge.y);
      if (edge.y == kVertex) near_.insert(edge.x);
    }
    for (const size_t vertex : near_) Color(vertex) = Harmonics(vertex) = 0.5f;
  }

  float& Color(size_t vertex) { return state_.parameters[vertex * components_ + kColorOffset]; }
  float& Harmonics(size_t vertex) {
    return state_.parameters[vertex * components_ + state_.layout.OffsetOf(kHarmonicsName)];
  }

  RadianceField box_ = WavyBox(0.4);
  FieldState state_;
  size_t components_ = 0;
  std::vector<float> evidence_;
  std::set<size_t> near_;
};

TEST_F(SmoothWeakColorsTest, GivesAColourWithoutEvidenceThatOfItsNeighbours) {
  evidence_[kVertex] = 0;
  const FieldState before = state_;
  SmoothWeakColors(box_.mesh, evidence_, state_);
  EXPECT_NEAR(Color(kVertex), 0.5f, 1e-5f);
  EXPECT_NEAR(Harmonics(kVertex), 0.5f, 1e-5f);
  // All others, and its density, are as before.
  Color(kVertex) = Harmonics(kVertex) = 3.0f;
  for (size_t row = 0; row < state_.rows(); ++row) {
    EXPECT_EQ(state_.parameters[row * components_ + kDensityOffset],
              before.parameters[row * components_ + kDensityOffset]);
    if (row == kVertex) continue;
    for (size_t i = 0; i < components_; ++i) {
      EXPECT_EQ(state_.parameters[row * components_ + i], before.parameters[row * components_ + i]);
    }
  }
}

TEST_F(SmoothWeakColorsTest, WeighsEvidenceAgainstTheNeighbours) {
  evidence_[kVertex] = float(kPriorEvidence);
  SmoothWeakColors(box_.mesh, evidence_, state_);
  EXPECT_NEAR(Color(kVertex), 1.75f, 1e-5f);
}

// A colour reaches vertices whose neighbours are unknown, too.
TEST_F(SmoothWeakColorsTest, SpreadsAmongVerticesWithoutEvidence) {
  evidence_[kVertex] = 0;
  for (const size_t vertex : near_) evidence_[vertex] = 0;
  for (size_t row = 0; row < state_.rows(); ++row) {
    if (evidence_[row] > 0) Color(row) = 0.25f;
  }
  SmoothWeakColors(box_.mesh, evidence_, state_);
  EXPECT_NEAR(Color(kVertex), 0.25f, 1e-3f);
}

}  // namespace
}  // namespace tetrec
