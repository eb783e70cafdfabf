#include "optimize/vertex_motion.h"

#include "field/change_storage.h"
#include "optimize/checkpoint.h"
#include "optimize/ring_scene.h"
#include "optimize/small_run.h"
#include "render/seen_colors.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetrec {
namespace {

OptimizeOptions MovingOptions(MoveChoice move, const DevicePace& pace = {}) {
  OptimizeOptions options = SmallRunOptions();
  options.renderer.pace = pace;
  options.move = move;
  options.iterations = 400;
  // So that nothing but positions can mend the pictures.
  options.color_rate = options.density_rate = 1e-9;
  options.density_decay = 0;
  return options;
}

constexpr float kDensity = 1.0f;  // so that the inside shows

bool IsInside(const glm::vec3& position) {
  const glm::vec3 size = glm::abs(position);
  return std::max({size.x, size.y, size.z}) < 0.99f;
}

struct MovingRun : SmallRun {
  explicit MovingRun(MoveChoice move = MoveChoice::kSafe, const DevicePace& pace = {})
      : SmallRun(MovingOptions(move, pace), 5, WavyBox(0.4, kDensity)) {
    motion.StartIfDue(1.0);
  }

  // The true field, but vertices inside are moved by up to `most`, with their colours.
  void PutMoved(float most) {
    RadianceField box = WavyBox(0.4, kDensity);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> shift(-most, most);
    std::vector<glm::vec3> moves;
    for (const glm::vec3& position : box.mesh.positions) {
      const glm::vec3 move(shift(random), shift(random), shift(random));
      moves.push_back(IsInside(position) ? move : glm::vec3(0.0f));
    }
    box.mesh.positions = MoveSafely(box.mesh, moves).positions;
    const FieldState state = StateOf(box);
    field.Put(std::move(box.mesh), state);
  }
  void Take(int steps_to_take, double progress) {
    for (int i = 0; i < steps_to_take; ++i) steps.Take(AtProgress(progress), false);
  }
  double Psnr() { return pictures.JudgeField().psnr; }
};

TEST(VertexMotion, BringsVerticesBackToWhereThePicturesWantThem) {
  MovingRun run;
  run.PutMoved(0.06f);
  const double moved = run.Psnr();
  run.Take(160, 0.1);
  EXPECT_GT(run.Psnr(), moved + 0.3);
  EXPECT_GT(run.motion.counts().moved, 0u);
}

// As on a GPU, where motions are rarer than the batches whose gradients they sum.
TEST(VertexMotion, SumsTheLastStepsBeforeEachMotion) {
  MovingRun run(MoveChoice::kSafe, DevicePace{.steps_per_motion = 40});
  run.PutMoved(0.06f);
  const uint64_t first_summed = 40 - kMostSummedBatches + 1;
  for (const uint64_t motion : {0u, 40u, 80u}) {
    for (uint64_t step = motion + 1; step <= motion + 40; ++step) {
      const bool is_summed = step - motion >= first_summed;
      EXPECT_EQ(HasPositions(run.motion.PartsOf(step, 0.1)), is_summed) << step;
      EXPECT_EQ(run.motion.CanResumeAfter(step, 0.1), !is_summed || step == motion + 40) << step;
    }
  }
  const auto positions = [&] { return run.field.mesh().positions; };
  const std::vector<glm::vec3> start = positions();
  run.Take(39, 0.1);
  EXPECT_EQ(positions(), start);
  run.Take(1, 0.1);
  EXPECT_NE(positions(), start);
  // Rates fall with the motions.
  EXPECT_EQ(run.motion.StepsForRates(400), 160u);
}

TEST(VertexMotion, ForgetsTheSumsThatAreDropped) {
  MovingRun kept, dropped, last;
  for (MovingRun* run : {&kept, &dropped, &last}) run->PutMoved(0.06f);
  kept.Take(16, 0.1);
  dropped.Take(15, 0.1);
  dropped.motion.DropSums();
  dropped.Take(1, 0.1);
  last.steps.Resume(15, 0);
  last.Take(1, 0.1);
  EXPECT_NE(dropped.field.mesh().positions, kept.field.mesh().positions);
  EXPECT_EQ(dropped.motion.counts().all(), last.motion.counts().all());
}

TEST(VertexMotion, KeepsTetsBetterWithARegulariser) {
  constexpr double kSharpness = 3;
  const auto badness_after = [](double strength) {
    MovingRun run;
    run.options.quality = {strength, kSharpness};
    run.options.position_rate = 0.02;
    run.PutMoved(0.06f);
    run.Take(80, 0.1);
    return RegulariserOf(run.field.mesh(), {1, kSharpness});
  };
  EXPECT_LT(badness_after(1e3), 0.99 * badness_after(0));
}

TEST(VertexMotion, LeavesTheBoundaryWhereItIs) {
  MovingRun run;
  run.PutMoved(0.06f);
  const TetMesh before = run.field.mesh();
  run.Take(32, 0.1);
  size_t moved = 0;
  for (size_t v = 0; v < before.positions.size(); ++v) {
    const bool moves = run.field.mesh().positions[v] != before.positions[v];
    EXPECT_FALSE(moves && !IsInside(before.positions[v])) << v;
    moved += size_t(moves);
  }
  EXPECT_GT(moved, 50u);
  CheckConvexDomain(run.field.mesh());
}

// Unit vectors towards the nearest capsule, along which the distance falls fastest.
std::vector<glm::vec3> TowardsCapsules(const std::vector<glm::vec3>& places,
                                       const std::vector<Capsule>& space) {
  constexpr float kStep = 1e-2f;
  const std::vector<float> here = DistancesToCapsules(places, space);
  std::vector<glm::vec3> ways(places.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<glm::vec3> beside = places;
    for (glm::vec3& place : beside) place[axis] += kStep;
    const std::vector<float> there = DistancesToCapsules(beside, space);
    for (size_t v = 0; v < ways.size(); ++v) ways[v][axis] = here[v] - there[v];
  }
  for (glm::vec3& way : ways) {
    way = glm::length(way) > 0 ? glm::normalize(way) : glm::vec3(1.0f, 0.0f, 0.0f);
  }
  return ways;
}

TEST(VertexMotion, NothingEntersTheSpaceOfTheCameras) {
  for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
    const Scene scene = RingOfCameras(12, 500);
    const std::vector<Capsule> space = FindCameraSpace(scene);
    SmallRun run(MovingOptions(MoveChoice::kSafe), 5, WavyBox(0.4, kDensity));
    OptimizeOptions options = run.options;
    options.camera_space = SpaceContent::kEmpty;
    FittedField field(options, scene, *run.renderer, run.batches);
    RadianceField box = WavyBox(0.4, kDensity);
    for (glm::vec3& position : box.mesh.positions) position *= 4.0f;  // the cameras stand inside
    const RadianceField stored = WithStorage(box, storage);
    field.Put(box.mesh, StateOf(stored));
    const auto inside = [&] { return InsideCapsules(PlacesOfRows(field.mesh(), storage), space); };
    const std::vector<uint8_t> before = inside();
    const std::vector<float> room = field.RoomOfVertices();
    const std::vector<glm::vec3> towards = TowardsCapsules(field.mesh().positions, space);
    size_t moved = 0;
    for (int motion = 0; motion < 20; ++motion) {
      std::vector<glm::vec3> moves;
      for (size_t v = 0; v < room.size(); ++v) {
        moves.push_back(0.0499f * std::min(room[v], 1.0f) * towards[v]);
      }
      moved += field.MoveVertices(moves).moved;
    }
    EXPECT_GT(moved, 1000u);
    EXPECT_GT(std::count(before.begin(), before.end(), 1), 0);
    EXPECT_EQ(inside(), before);
  }
}

TEST(VertexMotion, MovesNoVertexFartherThanItsRoom) {
  MovingRun run;
  run.PutMoved(0.06f);
  run.Take(16, 0.3);
  MotionState state = run.motion.state();
  const std::vector<glm::vec3> before = run.field.mesh().positions;
  for (size_t v = 0; v < state.room.size(); ++v) state.room[v] = v % 2 ? 0.05f : 0.0f;
  run.motion.Resume(state);
  run.Take(64, 0.3);
  float farthest = 0;
  for (size_t v = 0; v < before.size(); ++v) {
    const float way = glm::distance(run.field.mesh().positions[v], before[v]);
    farthest = std::max(farthest, way);
    EXPECT_LE(way, v % 2 ? 0.0501f : 0.0f);
  }
  EXPECT_GT(farthest, 0.0f);
}

TEST(VertexMotion, StopsBeforeTheEndOfARun) {
  MovingRun run;
  run.PutMoved(0.06f);
  const std::vector<glm::vec3> before = run.field.mesh().positions;
  run.Take(32, 0.9);
  EXPECT_EQ(run.field.mesh().positions, before);
  EXPECT_EQ(run.motion.counts().all(), 0u);
  MovingRun off(MoveChoice::kOff);
  off.PutMoved(0.06f);
  off.Take(32, 0.3);
  EXPECT_EQ(off.field.mesh().positions, before);
}

class VertexMotionAtAnyPace : public ::testing::TestWithParam<uint64_t> {};

INSTANTIATE_TEST_SUITE_P(, VertexMotionAtAnyPace, ::testing::Values(16, 40));

TEST_P(VertexMotionAtAnyPace, ContinuesAsItWouldHave) {
  const DevicePace pace{.steps_per_motion = GetParam()};
  MovingRun whole(MoveChoice::kSafe, pace), first(MoveChoice::kSafe, pace),
      second(MoveChoice::kSafe, pace);
  for (MovingRun* run : {&whole, &first}) run->PutMoved(0.06f);
  // If motions are far apart, after one and before gradients are summed for the next.
  const uint64_t stop = GetParam() == 16 ? 32 : 60;
  whole.Take(int(stop) + 32, 0.3);
  first.Take(int(stop), 0.3);
  ASSERT_TRUE(first.motion.CanResumeAfter(stop, 0.3));
  EXPECT_FALSE(first.motion.CanResumeAfter(31, 0.3));
  EXPECT_TRUE(first.motion.CanResumeAfter(31, 0.9));
  second.steps.Resume(first.steps.iteration(), first.steps.rays());
  second.field.Put(first.field.mesh(), first.field.ReadState());
  second.motion.Resume(first.motion.state());
  second.Take(32, 0.3);
  EXPECT_EQ(second.field.mesh().positions, whole.field.mesh().positions);
  EXPECT_EQ(second.field.ReadState().parameters, whole.field.ReadState().parameters);
}

TEST(VertexMotion, FollowsVerticesThroughARefinement) {
  MovingRun run;
  run.PutMoved(0.06f);
  run.Take(32, 0.3);
  const MotionState before = run.motion.state();
  const size_t count = before.second_moment.size();
  ASSERT_EQ(count, run.field.mesh().positions.size());
  Prolongation sources;
  for (uint32_t v = 0; v < count; ++v) {
    sources.inserted.push_back({uint32_t(count) - 1 - v, v, 0.25f});
    sources.kept.push_back(uint32_t(count) + v);
  }
  run.field.Put(run.field.mesh(), run.field.ReadState());
  run.motion.Follow(sources);
  const MotionState& after = run.motion.state();
  EXPECT_EQ(after.motions, before.motions);
  for (size_t v = 0; v < count; ++v) {
    EXPECT_FLOAT_EQ(after.second_moment[v].x, 0.75f * before.second_moment[count - 1 - v].x +
                                                  0.25f * before.second_moment[v].x);
    EXPECT_FLOAT_EQ(after.first_moment[v].y, 0.75f * before.first_moment[count - 1 - v].y +
                                                 0.25f * before.first_moment[v].y);
  }
  run.Take(16, 0.3);
  EXPECT_EQ(run.motion.state().motions, before.motions + 1);
}

TEST(VertexMotion, BeginsAnewOnAMeshThatItDoesNotKnow) {
  MovingRun run;
  run.PutMoved(0.06f);
  run.Take(32, 0.3);
  EXPECT_EQ(run.motion.state().motions, 2u);
  run.PutMoved(0.03f);
  run.Take(16, 0.3);
  EXPECT_EQ(run.motion.state().motions, 1u);
}

TEST(VertexMotion, StartsOnceTheFieldIsNoLongerCoarse) {
  for (const MoveChoice move : {MoveChoice::kSafe, MoveChoice::kOff}) {
    SmallRun run(MovingOptions(move), 5, WavyBox(0.4, kDensity));
    run.motion.StartIfDue(0.04);
    EXPECT_FALSE(run.motion.has_started());
    run.motion.StartIfDue(0.05);
    EXPECT_EQ(run.motion.has_started(), move == MoveChoice::kSafe);
    run.motion.StartIfDue(0.01);  // with --rounds, growth may fall
    EXPECT_EQ(run.motion.has_started(), move == MoveChoice::kSafe);
  }
}

// Of a mesh that has no motion yet, as after the return to a smaller one.
TEST(VertexMotion, HasAStateThatFitsTheMesh) {
  const ScratchFolder folder;
  MovingRun run;
  run.PutMoved(0.06f);
  run.Take(32, 0.3);
  Checkpoint checkpoint;
  const auto put_and_read = [&] {
    checkpoint.motion = run.motion.state();
    checkpoint.mesh = run.field.mesh();
    checkpoint.state = run.field.ReadState();
    checkpoint.row_rates = run.field.row_rates();
    WriteCheckpoint(folder / "c.bin", checkpoint);
    return ReadCheckpoint(folder / "c.bin").motion;
  };
  const uint64_t moved = run.motion.counts().moved;
  EXPECT_EQ(put_and_read().size.size(), run.field.mesh().positions.size());
  RadianceField other = WavyBox(0.4, kDensity);
  other.mesh = BuildDelaunay(std::span(other.mesh.positions).first(300)).mesh;
  other.color_srgb.resize(300);
  other.density.resize(300);
  run.field.Put(other.mesh, StateOf(other));
  EXPECT_TRUE(put_and_read().size.empty());
  EXPECT_EQ(put_and_read().counts.moved, moved);
  run.motion.Resume(put_and_read());
  run.Take(16, 0.3);
  EXPECT_EQ(put_and_read().size.size(), 300u);
  EXPECT_GT(run.motion.counts().all(), moved);
}

}  // namespace
}  // namespace tetrec
