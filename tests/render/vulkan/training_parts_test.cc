// The parts of a training step add up to the whole one, and carry attributes that no kernel knows.
#include "core/error.h"
#include "expect_error.h"
#include "field/extra_attribute.h"
#include "mesh/mesh_edges.h"
#include "render/create_renderer.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

namespace tetrec::test {
namespace {

constexpr int kPartsWidth = 40, kPartsHeight = 32;
constexpr glm::vec3 kBackground(0.2f, 0.7f, 0.4f);

class TrainingPartsTest : public EveryRendererTest {
 protected:
  // Skips the test if the device cannot add 64-bit integers.
  void SetUp() override {
    RendererTest::SetUp();
    if (IsSkipped()) return;
    try {
      CreateProbedRenderer({.deterministic = true});
    } catch (const EnvironmentError& error) {
      GTEST_SKIP() << error.what();
    }
  }

  // Of a random field and random pictures.
  ProbedRenderer& MakeLearner(bool deterministic, const FieldState& state, const TetMesh& mesh) {
    ProbedRenderer& renderer =
        MakeRenderer({.stop_transmittance = 0.0f, .deterministic = deterministic});
    TeachRandomPictures(renderer, state, mesh);
    return renderer;
  }
  void TeachRandomPictures(ProbedRenderer& renderer, const FieldState& state, const TetMesh& mesh) {
    renderer.SetState(mesh, state);
    std::mt19937 random(41);
    std::vector<TargetImage> targets;
    for (size_t v = 0; v < views_.size(); ++v) {
      targets.push_back({kPartsWidth, kPartsHeight, {}});
      for (int i = 0; i < kPartsWidth * kPartsHeight; ++i) {
        targets.back().rgba8.push_back(uint32_t(random()) & 0x7F7F7F7Fu);
      }
    }
    renderer.SetTargets(views_, targets);
  }
  ProbedRenderer& MakeLearner(bool deterministic) {
    return MakeLearner(deterministic, StateOf(field_), field_.mesh);
  }

  // A whole picture: one tile, and so are its halves.
  TrainingBatch Whole() const { return {.blocks = blocks_, .background_srgb = kBackground}; }

  RadianceField field_ = RandomField(150, 42, 6.0f);
  std::vector<RenderView> views_ = ThreeViews(kPartsWidth, kPartsHeight);
  std::vector<RayBlock> blocks_ = AllBlocks(views_[1].camera, 1);
};

INSTANTIATE_TEST_SUITE_P(, TrainingPartsTest, kEveryRenderer, RendererName);

std::vector<TrainingBatch> Halves(const TrainingBatch& whole) {
  std::vector<TrainingBatch> halves(2, whole);
  const size_t half = whole.blocks.size() / 2;
  halves[0].blocks = whole.blocks.first(half);
  halves[1].blocks = whole.blocks.subspan(half);
  for (TrainingBatch& batch : halves) batch.update_rays = whole.rays();
  return halves;
}

double Distance(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, size = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

void ExpectSameBits(const FieldState& a, const FieldState& b) {
  EXPECT_EQ(a.parameters, b.parameters);
  EXPECT_EQ(a.first_moment, b.first_moment);
  EXPECT_EQ(a.second_moment, b.second_moment);
}

TEST_P(TrainingPartsTest, GradientsOfHalvesSumToThoseOfTheWhole) {
  for (const LossKind loss : {LossKind::kL2, LossKind::kL1, LossKind::kSignedL2}) {
    TrainingBatch whole = Whole();
    whole.loss = loss;
    ProbedRenderer& renderer = MakeLearner(false);
    const StepResult of_whole = renderer.Forward(whole);
    renderer.Backward(GradientParts::kColorDensity);
    const GradientSums at_once = renderer.TakeGradients();
    double mean_loss = 0;
    for (const TrainingBatch& half : Halves(whole)) {
      mean_loss += 0.5 * renderer.Forward(half).loss;
      renderer.Backward(GradientParts::kColorDensity);
    }
    // Float sums in another order.
    EXPECT_NEAR(mean_loss, of_whole.loss, 1e-6 * std::abs(of_whole.loss));
    EXPECT_LT(Distance(renderer.TakeGradients().values, at_once.values), 1e-5);
    const GradientSums none = renderer.TakeGradients();
    EXPECT_EQ(*std::max_element(none.values.begin(), none.values.end()), 0.0);
    EXPECT_TRUE(none.position.empty());
  }
}

TEST_P(TrainingPartsTest, GradientsOfSignedL2ByColoursAddUpAndDoNotCancel) {
  ProbedRenderer& renderer = MakeLearner(false);
  const auto gradients = [&](LossKind loss) {
    TrainingBatch batch = Whole();
    batch.loss = loss;
    renderer.Forward(batch);
    renderer.Backward(GradientParts::kColorDensity);
    return renderer.TakeGradients().values;
  };
  const std::vector<double> signed_sums = gradients(LossKind::kSignedL2);
  const std::vector<double> sums = gradients(LossKind::kL2);
  const double largest = *std::max_element(signed_sums.begin(), signed_sums.end());
  size_t cancelled = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    if (i % kStandardComponents == kDensityOffset) continue;
    EXPECT_GE(signed_sums[i], std::abs(sums[i]) - 1e-5 * largest);
    cancelled += signed_sums[i] > 1.2 * std::abs(sums[i]) + 1e-5 * largest;
  }
  EXPECT_GT(cancelled, 0u);
}

TEST_P(TrainingPartsTest, RowsMoveByTheirShareOfTheRates) {
  const FieldState start = StateOf(field_);
  std::vector<RowRates> rates;
  for (size_t row = 0; row < start.rows(); ++row) rates.push_back({.share = 0.5f * float(row % 3)});
  const AdamUpdate update{.density_decay = 0.05};
  ProbedRenderer& whole = MakeLearner(true);
  whole.Step(Whole(), update);
  ProbedRenderer& shared = MakeLearner(true);
  shared.SetRowRates(rates);
  shared.Step(Whole(), update);
  const FieldState all = whole.ReadState(), some = shared.ReadState();
  size_t moved = 0;
  for (size_t i = 0; i < all.parameters.size(); ++i) {
    const float share = rates[i / kStandardComponents].share, before = start.parameters[i];
    if (share == 0.0f) {
      EXPECT_EQ(some.parameters[i], before);
    }
    // A colour that reaches 0 or 1 is cut off there.
    const bool is_cut =
        i % kStandardComponents < 3 && (all.parameters[i] <= 0.0f || all.parameters[i] >= 1.0f);
    if (is_cut) continue;
    const float full = all.parameters[i] - before;
    EXPECT_NEAR(some.parameters[i] - before, share * full, 1e-5);
    moved += full != 0.0f;
  }
  EXPECT_GT(moved, 100u);
  ExpectError<DataError>([&] { shared.SetRowRates(std::span(rates).first(1)); }, {"1 rates for"});
  rates[2].share = 1.5f;
  ExpectError<DataError>([&] { shared.SetRowRates(rates); }, {"rate share 2 is 1.5"});
  rates[2] = {.kept_density = -1.0f};
  ExpectError<DataError>([&] { shared.SetRowRates(rates); }, {"kept density 2 is -1"});
  rates[2] = {.least_density = std::numeric_limits<float>::quiet_NaN()};
  ExpectError<DataError>([&] { shared.SetRowRates(rates); }, {"least density 2 is not a number"});
  // A new state has whole rates again.
  shared.SetState(field_.mesh, start);
  shared.Step(Whole(), update);
  EXPECT_EQ(shared.ReadState().parameters, all.parameters);
}

TEST_P(TrainingPartsTest, HalvesAndOneUpdateMakeTheBitsOfOneDeterministicStep) {
  ProbedRenderer& whole = MakeLearner(true);
  ProbedRenderer& halves = MakeLearner(true);
  for (uint32_t i = 1; i <= 3; ++i) {
    const AdamUpdate update{.step = i, .density_decay = 0.1};
    whole.Step(Whole(), update);
    for (const TrainingBatch& half : Halves(Whole())) {
      halves.Forward(half);
      halves.Backward(GradientParts::kColorDensity);
    }
    halves.Update(update);
  }
  ExpectSameBits(halves.ReadState(), whole.ReadState());
  EXPECT_NE(whole.ReadState().parameters, StateOf(field_).parameters);
}

TEST_P(TrainingPartsTest, ForwardTakesAnyBlocks) {
  ProbedRenderer& renderer = MakeLearner(true);
  TrainingBatch batch = Whole();
  batch.jitter_px = 0;
  const std::array<RayBlock, 2> apart{batch.blocks.front(), batch.blocks.back()};
  double sum = 0;
  for (const RayBlock& block : apart) {
    batch.blocks = std::span(&block, 1);
    sum += renderer.Forward(batch).squared_error;
  }
  batch.blocks = apart;
  EXPECT_NEAR(renderer.Forward(batch).squared_error, sum / 2, 1e-5 * sum);
  EXPECT_GT(sum, 1e-4);
}

TEST_P(TrainingPartsTest, TilesOfDssimCanBeSummedToo) {
  ProbedRenderer& whole = MakeLearner(true);
  if (whole.NeedsTiles()) GTEST_SKIP() << "a batch of this renderer is one tile";
  ProbedRenderer& halves = MakeLearner(true);
  TrainingBatch batch = Whole();
  batch.dssim_weight = 0.3f;
  batch.tiles = {kPartsWidth / kRayBlockWidth, kPartsHeight / kRayBlockHeight / 2};
  whole.Step(batch, {});
  for (const TrainingBatch& half : Halves(batch)) {
    halves.Forward(half);
    halves.Backward(GradientParts::kColorDensity);
  }
  halves.Update({});
  ExpectSameBits(halves.ReadState(), whole.ReadState());
}

TEST_P(TrainingPartsTest, GradientsTakenAndAddedAgainMakeTheBitsOfTheStep) {
  for (const bool deterministic : {false, true}) {
    ProbedRenderer& fused = MakeLearner(deterministic);
    ProbedRenderer& parts = MakeLearner(deterministic);
    fused.Step(Whole(), {});
    const StepResult result = parts.Forward(Whole());
    parts.Backward(GradientParts::kColorDensity);
    const GradientSums sums = parts.TakeGradients();
    parts.AddGradients(sums);
    parts.Update({});
    if (deterministic) {
      ExpectSameBits(parts.ReadState(), fused.ReadState());
    } else {
      // Adam normalises gradients, whose float sums differ in order: moments are compared.
      const FieldState a = parts.ReadState(), b = fused.ReadState();
      EXPECT_LT(Distance({a.first_moment.begin(), a.first_moment.end()},
                         {b.first_moment.begin(), b.first_moment.end()}),
                1e-5);
    }
    fused.Step(Whole(), {.step = 2});
    EXPECT_EQ(fused.Step(Whole(), {.step = 3}).loss, result.loss) << "one step late";
  }
}

// Sums from elsewhere: no backward pass gave them their scale.
TEST_P(TrainingPartsTest, GivenGradientsMoveParametersByTheirFormulas) {
  for (const bool deterministic : {false, true}) {
    for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
      RadianceField field = RandomField(20, 43, 3.0f, storage);
      for (float& density : field.density) density = std::max(density, 0.1f);
      field.others = {{kExtraAttribute, std::vector<float>(5 * RowCount(field), 0.25f)}};
      const FieldState start = StateOf(field);
      ProbedRenderer& renderer = MakeLearner(deterministic, start, field.mesh);
      std::mt19937 random(44);
      std::normal_distribution<double> normal;
      std::vector<double> parameters(start.parameters.begin(), start.parameters.end());
      std::vector<double> first(parameters.size()), second(parameters.size());
      for (uint32_t step = 1; step <= 2; ++step) {
        GradientSums sums;
        for (size_t i = 0; i < parameters.size(); ++i) sums.values.push_back(normal(random));
        const AdamUpdate update{.step = step, .color_rate = 0.01, .density_rate = 0.05};
        renderer.AddGradients(sums);
        renderer.Update(update);
        for (size_t i = 0; i < parameters.size(); ++i) {
          if (i % 9 >= kStandardComponents) continue;
          const bool is_density = i % 9 == kDensityOffset;
          const double gradient = sums.values[i] * (is_density ? std::exp(parameters[i]) : 1.0);
          const double b1 = update.beta1, b2 = update.beta2;
          first[i] = b1 * first[i] + (1 - b1) * gradient;
          second[i] = b2 * second[i] + (1 - b2) * gradient * gradient;
          parameters[i] -= (is_density ? 0.05 : 0.01) * first[i] / (1 - std::pow(b1, step)) /
                           std::sqrt(second[i] / (1 - std::pow(b2, step)));
          if (i % 9 < kDensityOffset) parameters[i] = std::clamp(parameters[i], 0.0, 1.0);
        }
        // Attributes behind density: no momentum, one moment per row.
        for (size_t row = 0; row < start.rows(); ++row) {
          double mean = 0;
          for (size_t i = 9 * row + 4; i < 9 * row + 9; ++i) {
            mean += sums.values[i] * sums.values[i] / 5;
          }
          double& moment = second[9 * row + 4];
          moment = step == 1 ? mean : update.beta2 * moment + (1 - update.beta2) * mean;
          for (size_t i = 9 * row + 4; i < 9 * row + 9; ++i) {
            parameters[i] -= 0.01 / std::sqrt(moment) * sums.values[i];
          }
        }
      }
      const FieldState end = renderer.ReadState();
      for (size_t i = 0; i < parameters.size(); ++i) {
        // Rates times some roundings of float, and the logarithms' own.
        ASSERT_NEAR(end.parameters[i], parameters[i], 1e-5) << "component " << i % 9;
      }
    }
  }
}

TEST_P(TrainingPartsTest, AnotherAttributeComesBackAsItWasSet) {
  for (const FieldLayout& layout : {WithExtra({}), WithExtra(kCellLayout)}) {
    ExpectStateComesBack(MakeRenderer(), field_.mesh, layout);
  }
}

// Pictures and steps are the same bits with it and without.
TEST_P(TrainingPartsTest, KernelsIgnoreAnAttributeThatTheyDoNotKnow) {
  RadianceField with_extra = field_;
  with_extra.others = {{kExtraAttribute, std::vector<float>(5 * RowCount(field_), 7.0f)}};
  ProbedRenderer& plain = MakeLearner(true);
  ProbedRenderer& other = MakeLearner(true, StateOf(with_extra), field_.mesh);
  for (ProbedRenderer* renderer : {&plain, &other}) {
    for (uint32_t i = 1; i <= 2; ++i) renderer->Step(Whole(), {.step = i});
  }
  EXPECT_EQ(plain.Render(views_[0], 1).color_srgb, other.Render(views_[0], 1).color_srgb);
  const RadianceField a = FieldOf(field_.mesh, plain.ReadState()),
                      b = FieldOf(field_.mesh, other.ReadState());
  EXPECT_EQ(a.density, b.density);
  EXPECT_EQ(a.color_srgb, b.color_srgb);
  EXPECT_EQ(b.others[0].values, with_extra.others[0].values);
}

// Plain descent on the host in Adam's place.
TEST_P(TrainingPartsTest, ParametersOfAnotherOptimiserLowerTheLoss) {
  ProbedRenderer& renderer = MakeLearner(false);
  const double before = renderer.Forward(Whole()).loss;
  renderer.Backward(GradientParts::kColorDensity);
  const std::vector<double> gradient = renderer.TakeGradients().values;
  const FieldState start = renderer.ReadState();
  std::vector<float> parameters = start.parameters;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (i % 4 != kDensityOffset) parameters[i] -= float(20.0 * gradient[i]);
  }
  renderer.WriteParameters(parameters);
  EXPECT_EQ(renderer.ReadState().parameters, parameters);
  EXPECT_EQ(renderer.ReadState().first_moment, start.first_moment);
  EXPECT_LT(renderer.Forward(Whole()).loss, before);
  parameters.pop_back();
  EXPECT_THROW(renderer.WriteParameters(parameters), DataError);
  parameters.push_back(std::nanf(""));
  EXPECT_THROW(renderer.WriteParameters(parameters), DataError);
}

// Those of the picture's gradient, which the backward pass of a batch gets from the loss.
TEST_P(TrainingPartsTest, PositionsAndTheirAbsoluteSumsAreThoseOfBackpropagation) {
  for (const bool deterministic : {false, true}) {
    ProbedRenderer& renderer = MakeLearner(deterministic);
    const TargetImage black{kPartsWidth, kPartsHeight,
                            std::vector<uint32_t>(kPartsWidth * kPartsHeight, 0xFF000000u)};
    renderer.SetTargets(views_, std::vector<TargetImage>(views_.size(), black));
    TrainingBatch batch = Whole();
    batch.background_srgb = glm::vec3(0.0f);
    renderer.Forward(batch);
    renderer.Backward(GradientParts::kColorDensityPosition);
    const GradientSums sums = renderer.TakeGradients();
    const RenderedImage image = renderer.Render(views_[1], 1);
    std::vector<glm::vec4> by_pixel;
    for (const glm::vec3& color : image.color_srgb) {
      by_pixel.emplace_back(2.0f / (3.0f * float(batch.rays())) * color, 0.0f);
    }
    const FieldGradient truth =
        renderer.Backpropagate(views_[1], by_pixel, GradientParts::kColorDensityPosition);
    ASSERT_EQ(sums.position.size(), truth.position.size());
    std::vector<double> positions, true_positions;
    for (size_t v = 0; v < truth.position.size(); ++v) {
      for (int i = 0; i < 3; ++i) {
        positions.push_back(sums.position[v][i]);
        true_positions.push_back(truth.position[v][i]);
      }
    }
    EXPECT_LT(Distance(positions, true_positions), 1e-4);
    EXPECT_LT(Distance(sums.absolute_position,
                       {truth.absolute_position.begin(), truth.absolute_position.end()}),
              1e-4);
    renderer.AddGradients(sums);
    renderer.AddGradients(sums);
    const GradientSums twice = renderer.TakeGradients();
    for (double& value : positions) value *= 2;
    std::vector<double> summed;
    for (const glm::dvec3& p : twice.position) summed.insert(summed.end(), {p.x, p.y, p.z});
    EXPECT_LT(Distance(summed, positions), 1e-6);
  }
}

TEST_P(TrainingPartsTest, RefusesPartsInAnOrderThatMeansNothing) {
  ProbedRenderer& renderer = MakeLearner(true);
  EXPECT_THROW(renderer.Backward(GradientParts::kColorDensity), BugError);
  EXPECT_THROW(renderer.AddGradients({.values = {1.0}}), BugError);
  if (GetParam() == RendererKind::kReference) return;  // has no quanta
  renderer.Forward(Halves(Whole())[0]);
  renderer.Backward(GradientParts::kColorDensity);
  TrainingBatch other = Whole();
  other.update_rays = 3 * Whole().rays();
  renderer.Forward(other);
  EXPECT_THROW(renderer.Backward(GradientParts::kColorDensity), BugError);
}

TEST_P(TrainingPartsTest, ScoresCanShareOutAbsoluteResiduals) {
  ProbedRenderer& renderer = MakeLearner(true);
  const TargetImage black{kPartsWidth, kPartsHeight,
                          std::vector<uint32_t>(kPartsWidth * kPartsHeight, 0xFF000000u)};
  renderer.SetTargets(views_, std::vector<TargetImage>(views_.size(), black));
  double squares = 0, absolutes = 0, residuals = 0;
  for (const glm::vec4& ray : renderer.MarchBlocks(views_[1], AllBlocks(views_[1].camera))) {
    const glm::dvec3 color(ray);
    squares += glm::dot(color, color) * -std::expm1(-double(ray.a));
    absolutes += (color.r + color.g + color.b) * -std::expm1(-double(ray.a));
    residuals += color.r + color.g + color.b;
  }
  for (const auto& [kind, expected] : {std::pair{ScoreKind::kSquaredResidual, squares},
                                       std::pair{ScoreKind::kAbsoluteResidual, absolutes}}) {
    renderer.ClearScores();
    renderer.AddScores({.blocks = blocks_}, kind);
    const std::vector<float> scores = renderer.ReadScores().errors;
    const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
    EXPECT_LE(sum, expected * (1.0 + 1e-4));
    // Shares below 1e-3 are left out; a ray meets 40 tets at most.
    EXPECT_GE(sum, expected - 40 * 1e-3 * residuals);
    EXPECT_GT(sum, 0.9 * expected);
  }
}

TEST_P(TrainingPartsTest, ScoresCanCountTheLightThatRaysLose) {
  ProbedRenderer& renderer = MakeLearner(true);
  double light = 0, rays = 0;
  for (const glm::vec4& ray : renderer.MarchBlocks(views_[1], AllBlocks(views_[1].camera))) {
    light += -std::expm1(-double(ray.a));
    ++rays;
  }
  renderer.ClearScores();
  renderer.AddScores({.blocks = blocks_}, ScoreKind::kSquaredResidual);
  const std::vector<float> scores = renderer.ReadScores().light;
  const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
  EXPECT_LE(sum, light * (1.0 + 1e-4));
  // Shares below 1e-2 are left out; a ray meets 40 tets at most.
  EXPECT_GE(sum, light - 40 * 1e-2 * rays);
  EXPECT_GT(sum, 0.7 * light);
  for (const float score : scores) EXPECT_TRUE(score == 0.0f || score > 0.0099f);
}

TEST_P(TrainingPartsTest, EdgesGetTheSumsOfTheReference) {
  const MeshEdges edges = EdgesOf(field_.mesh);
  const auto sums_of = [&](ProbedRenderer& renderer) {
    renderer.ClearEdgeSums(edges);
    for (const TrainingBatch& batch : Halves(Whole())) renderer.AddEdgeSums(batch);
    return renderer.TakeEdgeSums();
  };
  const auto reference =
      CreateProbedRenderer({.kind = RendererKind::kReference, .stop_transmittance = 0.0f});
  TeachRandomPictures(*reference, StateOf(field_), field_.mesh);
  const std::vector<EdgeSums> expected = sums_of(*reference);
  std::array<double, 4> largest{};
  const auto parts_of = [](const EdgeSums& sums) {
    return std::array{glm::length(sums.color), sums.density, sums.color_curvature,
                      sums.density_curvature};
  };
  for (const EdgeSums& sums : expected) {
    for (size_t i = 0; i < 4; ++i) largest[i] = std::max(largest[i], std::abs(parts_of(sums)[i]));
  }
  for (const bool deterministic : {false, true}) {
    const std::vector<EdgeSums> sums = sums_of(MakeLearner(deterministic));
    ASSERT_EQ(sums.size(), edges.ends.size());
    for (size_t e = 0; e < sums.size(); ++e) {
      EXPECT_NEAR(glm::distance(sums[e].color, expected[e].color), 0.0, 3e-3 * largest[0]);
      for (size_t i = 1; i < 4; ++i) {
        EXPECT_NEAR(parts_of(sums[e])[i], parts_of(expected[e])[i], 3e-3 * largest[i])
            << "edge " << e << ", sum " << i;
      }
    }
  }
}

}  // namespace
}  // namespace tetrec::test
