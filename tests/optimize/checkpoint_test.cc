#include "optimize/checkpoint.h"

#include "core/error.h"
#include "core/file.h"
#include "core/random.h"
#include "expect_error.h"
#include "field/extra_attribute.h"
#include "geometry/small_motion.h"
#include "mesh/delaunay.h"
#include "scratch_folder.h"

#include <cstring>
#include <limits>

namespace tetrec {
namespace {

// Where the fields start: "TETRECKI", u64 iteration, f64 seconds, u64 rays, u64 x 2, f64 and u64 of
// the pace, u32 x 2, u64 and f64 of the rounds, u64 and f64 x 2 x 2 of the judging views, u64 and
// u64 x 11 of their growth, u32 x 2, f64, u64, u64 and f64 x 2 of the coarsening, u64 x 3 and f64
// of the convergence, u64 metrics bytes, u32 x 3 harmonics, u32 fine rays, u64 V, u64 T, then the
// layout: u32 storage, u32 attributes, and of "color" and "density" the length of the name, the
// name, and 3 u32 each. Positions follow.
constexpr size_t kSecondsAt = 16, kRaysPerStepAt = 32, kFineRaysAt = 324, kVertexCountAt = 328,
                 kTetCountAt = 336, kStorageAt = 344,
                 kPositionsAt = kStorageAt + 8 + (4 + 5 + 12) + (4 + 7 + 12);

constexpr int kPoses = 2;
constexpr size_t kStrayBytes = 4 + 8 + kPoses * 5;  // a flag and a ratio per photo
constexpr size_t kPosesBytes = 4 + 8 + kPoses * 13 * sizeof(double) + kStrayBytes;

Checkpoint MakeCheckpoint(const FieldLayout& layout = {}) {
  Random random(5);
  const auto unit = [&random] { return float(random.Uniform()); };
  std::vector<glm::vec3> points;
  for (int i = 0; i < 20; ++i) {
    const float x = unit(), y = unit(), z = unit();
    points.emplace_back(x, y, z);
  }
  Checkpoint checkpoint;
  checkpoint.iteration = (uint64_t{1} << 40) + 3;
  checkpoint.seconds = 12.375;
  checkpoint.rays = 987654321012345;
  checkpoint.pace = {
      .rays_per_step = 65536, .views_per_batch = 16, .speed = 10, .steps_per_motion = 64};
  checkpoint.share_of_rates = 0.01;
  checkpoint.rounds = {4, 1, 9, 23.5, {{1.5, 16.0}, {0.25, 32.0}}, {}};
  checkpoint.rounds.steps.push_back({.iteration = 12, .seconds = 2.5, .psnr = 21.0});
  checkpoint.coarsening = {0, 1, 0.5, 77, {{2.5, 64.0}}};
  checkpoint.convergence = {500, 1, 700, 25.5};
  checkpoint.metrics_bytes = 777;
  checkpoint.fine_rays = TrialState::kNotUsed;
  checkpoint.mesh = BuildDelaunay(points).mesh;
  FieldState& state = checkpoint.state;
  const size_t rows = RowCount(checkpoint.mesh, layout.storage);
  state = WithoutMoments(layout, std::vector<float>(rows * size_t(layout.Components())));
  for (auto* values : {&state.parameters, &state.first_moment, &state.second_moment}) {
    for (float& value : *values) value = unit();
  }
  for (size_t row = 0; row < rows; ++row) {
    checkpoint.row_rates.push_back({.share = float(row % 2)});
    if (row % 3 == 0) checkpoint.row_rates.back().kept_density = unit();
    if (row % 5 == 0) checkpoint.row_rates.back().least_density = unit();
  }
  MotionState& motion = checkpoint.motion;
  motion.motions = 9;
  motion.counts = {5, 4, 3};
  for (size_t v = 0; v < checkpoint.mesh.positions.size(); ++v) {
    motion.first_moment.emplace_back(unit() - 0.5f, unit(), unit());
    motion.second_moment.push_back(glm::vec3(unit(), unit(), unit()));
    motion.size.push_back(unit());
    motion.room.push_back(unit());
  }
  checkpoint.exposure.exposures.resize(3);
  checkpoint.exposure.sums.resize(3);
  for (int view = 0; view < 3; ++view) {
    checkpoint.exposure.exposures[size_t(view)] = {glm::dvec3(1 + unit(), 1, 0.5),
                                                   glm::dvec3(unit(), 0, -0.1)};
    for (GainOffsetSums& sums : checkpoint.exposure.sums[size_t(view)]) sums.Add(unit(), 1, unit());
  }
  checkpoint.stray = {1, {0, 1}, {5.5f, 0.0f}};
  checkpoint.poses.sweeps = 2;
  for (int view = 0; view < kPoses; ++view) {
    checkpoint.poses.poses.push_back({MotionOf({unit(), 0, 0}, {0, unit(), 1}), 1.5});
  }
  return checkpoint;
}

// Without the checksum.
std::vector<uint8_t> BytesOf(const Checkpoint& checkpoint) {
  const ScratchFolder folder;
  WriteCheckpoint(folder / "checkpoint.bin", checkpoint);
  std::vector<uint8_t> bytes = ReadBytes(folder / "checkpoint.bin");
  return {bytes.begin(), bytes.end() - 64};
}

template <class T>
std::vector<uint8_t> With(std::vector<uint8_t> bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
  return bytes;
}

TEST(Checkpoint, ReadsBackAsItWasWritten) {
  for (FieldLayout layout : {FieldLayout{}, kCellLayout, WithExtra({}), WithExtra(kCellLayout)}) {
    const ScratchFolder folder;
    const Checkpoint written = MakeCheckpoint(layout);
    WriteCheckpoint(folder / "checkpoint.bin", written);
    const Checkpoint read = ReadCheckpoint(folder / "checkpoint.bin");
    EXPECT_EQ(read.iteration, written.iteration);
    EXPECT_EQ(read.seconds, written.seconds);
    EXPECT_EQ(read.rays, written.rays);
    EXPECT_EQ(read.pace, written.pace);
    EXPECT_EQ(read.share_of_rates, written.share_of_rates);
    EXPECT_EQ(read.fine_rays, written.fine_rays);
    EXPECT_TRUE(read.rounds == written.rounds);
    EXPECT_TRUE(read.coarsening == written.coarsening);
    EXPECT_TRUE(read.convergence == written.convergence);
    EXPECT_EQ(read.metrics_bytes, written.metrics_bytes);
    EXPECT_EQ(read.mesh.positions, written.mesh.positions);
    EXPECT_EQ(read.mesh.tets, written.mesh.tets);
    EXPECT_EQ(read.mesh.neighbors, written.mesh.neighbors);
    EXPECT_EQ(read.state.layout, layout);
    EXPECT_EQ(read.state.parameters, written.state.parameters);
    EXPECT_EQ(read.state.first_moment, written.state.first_moment);
    EXPECT_EQ(read.state.second_moment, written.state.second_moment);
    ASSERT_EQ(read.row_rates.size(), written.row_rates.size());
    for (size_t row = 0; row < read.row_rates.size(); ++row) {
      EXPECT_EQ(read.row_rates[row].share, written.row_rates[row].share);
      EXPECT_EQ(read.row_rates[row].kept_density, written.row_rates[row].kept_density);
      EXPECT_EQ(read.row_rates[row].least_density, written.row_rates[row].least_density);
    }
    EXPECT_EQ(read.motion.motions, written.motion.motions);
    EXPECT_EQ(read.motion.first_moment, written.motion.first_moment);
    EXPECT_EQ(read.motion.second_moment, written.motion.second_moment);
    EXPECT_EQ(read.motion.size, written.motion.size);
    EXPECT_EQ(read.motion.room, written.motion.room);
    EXPECT_EQ(read.motion.counts.stopped, 3u);
    EXPECT_EQ(read.exposure.exposures, written.exposure.exposures);
    EXPECT_EQ(read.exposure.sums, written.exposure.sums);
    EXPECT_EQ(read.stray.looks, written.stray.looks);
    EXPECT_EQ(read.stray.left_out, written.stray.left_out);
    EXPECT_EQ(read.stray.tried_ratio, written.stray.tried_ratio);
    EXPECT_EQ(read.poses.sweeps, written.poses.sweeps);
    ASSERT_EQ(read.poses.poses.size(), written.poses.poses.size());
    for (size_t i = 0; i < read.poses.poses.size(); ++i) {
      const CorrectedPose &pose = read.poses.poses[i], &before = written.poses.poses[i];
      EXPECT_EQ(pose.cam_from_world.rotation, before.cam_from_world.rotation);
      EXPECT_EQ(pose.cam_from_world.translation, before.cam_from_world.translation);
      EXPECT_EQ(pose.depth, before.depth);
    }
  }
}

TEST(Checkpoint, EveryFlippedBitAndEveryLengthOfAFileIsNoticed) {
  const ScratchFolder folder;
  WriteCheckpoint(folder / "checkpoint.bin", MakeCheckpoint());
  const std::vector<uint8_t> good = ReadBytes(folder / "checkpoint.bin");
  for (size_t bit = 0; bit < 8 * good.size(); bit += 611) {
    const auto flipped = uint8_t(good[bit / 8] ^ 1 << bit % 8);
    WriteBytes(folder / "damaged", With(good, bit / 8, flipped));
    ExpectError<DataError>([&] { ReadCheckpoint(folder / "damaged"); },
                           {"damaged: is ", "force a fresh run"});
  }
  for (size_t size = 0; size < good.size(); size += 197) {
    WriteBytes(folder / "cut", std::span(good).first(size));
    ExpectError<DataError>([&] { ReadCheckpoint(folder / "cut"); }, {"cut", "force a fresh run"});
  }
}

TEST(Checkpoint, NamesTheFileWhoseMeshIsWrong) {
  const ScratchFolder folder;
  Checkpoint checkpoint = MakeCheckpoint();
  checkpoint.mesh.neighbors[0] = glm::uvec4(kNoTet);
  WriteCheckpoint(folder / "checkpoint.bin", checkpoint);
  ExpectError<DataError>([&] { ReadCheckpoint(folder / "checkpoint.bin"); },
                         {"checkpoint.bin: tet ", "no link back; force a fresh run"});
}

TEST(Checkpoint, RefusesExposuresThatAreNotPossible) {
  const auto refused = [](auto&& damage, const std::string& what) {
    Checkpoint checkpoint = MakeCheckpoint();
    damage(checkpoint.exposure);
    const std::vector<uint8_t> bytes = BytesOf(checkpoint);
    ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {"c.bin", what});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](ExposureState& e) { e.exposures[1].gain.g = 0; }, "a gain of exposure 1");
  refused([&](ExposureState& e) { e.exposures[2].gain.b = nan; }, "a gain of exposure 2");
  refused([&](ExposureState& e) { e.exposures[0].offset.r = nan; }, "an offset of exposure 0");
  refused([&](ExposureState& e) { e.sums[1][2].yx = nan; }, "a sum of exposure 1");
  refused([](ExposureState& e) { e.sums[1][2].ww = -1; }, "a sum of exposure 1");
}

TEST(Checkpoint, RefusesAHugeCountOfExposuresBeforeItTakesMemory) {
  const std::vector<uint8_t> good = BytesOf(MakeCheckpoint());
  const size_t count_at =
      good.size() - kPosesBytes - 3 * (6 + 15) * sizeof(double) - sizeof(uint64_t);
  for (const uint64_t count : {uint64_t{2}, uint64_t{4}, uint64_t{1} << 60, ~uint64_t{0}}) {
    ExpectError<DataError>([&] { ParseCheckpoint(With(good, count_at, count), "c.bin"); },
                           {"c.bin"});
  }
}

TEST(Checkpoint, RefusesRatesThatAreNotPossible) {
  const auto refused = [](const RowRates& rates, const std::string& what) {
    Checkpoint checkpoint = MakeCheckpoint();
    checkpoint.row_rates[3] = rates;
    const std::vector<uint8_t> bytes = BytesOf(checkpoint);
    ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {"c.bin", what});
  };
  refused({.share = 1.5f}, "rate share 3 is 1.5");
  refused({.share = std::numeric_limits<float>::quiet_NaN()}, "rate share 3 is nan");
  refused({.kept_density = -1.0f}, "kept density 3 is -1");
  refused({.least_density = std::numeric_limits<float>::quiet_NaN()},
          "least density 3 is not a number");
}

TEST(Checkpoint, RefusesPosesThatAreNotPossible) {
  const auto refused = [](auto&& damage, const std::string& what) {
    Checkpoint checkpoint = MakeCheckpoint();
    damage(checkpoint.poses.poses);
    const std::vector<uint8_t> bytes = BytesOf(checkpoint);
    ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {"c.bin", what});
  };
  using Poses = std::vector<CorrectedPose>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](Poses& p) { p[1].cam_from_world.rotation[0] *= -1.0; }, "the rotation of pose 1");
  refused([&](Poses& p) { p[0].cam_from_world.rotation[2][1] = nan; }, "the rotation of pose 0");
  refused([&](Poses& p) { p[1].cam_from_world.translation.z = nan; }, "the translation of pose 1");
  refused([](Poses& p) { p[0].depth = -1; }, "the depth of pose 0");
}

TEST(Checkpoint, RefusesAHugeCountBeforeItTakesMemory) {
  const std::vector<uint8_t> good = BytesOf(MakeCheckpoint());
  for (const size_t count_at : {good.size() - kPosesBytes + 4, good.size() - kStrayBytes + 4}) {
    for (const uint64_t count : {uint64_t{1}, uint64_t{3}, uint64_t{1} << 60, ~uint64_t{0}}) {
      ExpectError<DataError>([&] { ParseCheckpoint(With(good, count_at, count), "c.bin"); },
                             {"c.bin"});
    }
  }
}

TEST(Checkpoint, RefusesFlagsOfPhotosThatAreNotPossible) {
  Checkpoint checkpoint = MakeCheckpoint();
  checkpoint.stray.left_out[1] = 2;
  const std::vector<uint8_t> bytes = BytesOf(checkpoint);
  ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); },
                         {"c.bin: the flag of photo 1 is 2; expected 0 or 1"});
  checkpoint = MakeCheckpoint();
  checkpoint.stray.tried_ratio[0] = -1;
  const std::vector<uint8_t> negative = BytesOf(checkpoint);
  ExpectError<DataError>([&] { ParseCheckpoint(negative, "c.bin"); },
                         {"c.bin: the ratio of errors of photo 0 is -1; expected 0 or more"});
}

// Files of the version before, which had no ratios of errors.
TEST(Checkpoint, RefusesTheVersionBefore) {
  std::vector<uint8_t> bytes = BytesOf(MakeCheckpoint());
  bytes[7] = 'G';
  ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); },
                         {"c.bin: is not a checkpoint of this version of Tetrec"});
}

TEST(Checkpoint, RefusesAnotherStorageThanThatOfItsRows) {
  const std::vector<uint8_t> vertices = BytesOf(MakeCheckpoint());
  const std::vector<uint8_t> cells = BytesOf(MakeCheckpoint(kCellLayout));
  EXPECT_THROW(ParseCheckpoint(With(vertices, kStorageAt, uint32_t{1}), "c.bin"), DataError);
  EXPECT_THROW(ParseCheckpoint(With(cells, kStorageAt, uint32_t{0}), "c.bin"), DataError);
  for (const uint32_t storage : {2u, 256u, ~0u}) {
    ExpectError<DataError>([&] { ParseCheckpoint(With(cells, kStorageAt, storage), "c.bin"); },
                           {"c.bin", "storage"});
  }
}

TEST(Checkpoint, RefusesEveryPrefixAndTrailingBytes) {
  std::vector<uint8_t> bytes = BytesOf(MakeCheckpoint());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THROW(ParseCheckpoint(std::span(bytes).first(size), "c.bin"), DataError) << size;
  }
  bytes.push_back(0);
  EXPECT_THROW(ParseCheckpoint(bytes, "c.bin"), DataError);
}

TEST(Checkpoint, RefusesHugeCountsBeforeItTakesMemory) {
  const std::vector<uint8_t> good = BytesOf(MakeCheckpoint());
  for (const size_t at : {kVertexCountAt, kTetCountAt}) {
    for (const uint64_t count :
         {uint64_t{1} << 32, uint64_t{1} << 60, uint64_t{1} << 62, ~uint64_t{0}}) {
      ExpectError<DataError>([&] { ParseCheckpoint(With(good, at, count), "c.bin"); }, {"c.bin"});
    }
  }
}

TEST(Checkpoint, RefusesUnknownStatesOfTrials) {
  const std::vector<uint8_t> good = BytesOf(MakeCheckpoint());
  ExpectError<DataError>([&] { ParseCheckpoint(With(good, kRaysPerStepAt, uint64_t{0}), "c.bin"); },
                         {"c.bin", "0 rays per step"});
  ExpectError<DataError>([&] { ParseCheckpoint(With(good, kFineRaysAt, uint32_t{3}), "c.bin"); },
                         {"c.bin", "fine rays", "3"});
}

TEST(Checkpoint, RefusesMotionsThatAreNotPossible) {
  const auto refused = [](auto&& damage, const std::string& what) {
    Checkpoint checkpoint = MakeCheckpoint();
    damage(checkpoint.motion);
    const std::vector<uint8_t> bytes = BytesOf(checkpoint);
    ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {"c.bin", what});
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refused([&](MotionState& m) { m.first_moment[3].z = nan; }, "the motion of vertex 3");
  refused([](MotionState& m) { m.second_moment[2].y = -1e-9f; }, "the motion of vertex 2");
  refused([&](MotionState& m) { m.size[0] = nan; }, "the motion of vertex 0");
  refused([](MotionState& m) { m.room[1] = -1; }, "the motion of vertex 1");
  refused(
      [](MotionState& m) {
        m.first_moment.pop_back();
        m.second_moment.pop_back();
        m.size.pop_back();
        m.room.pop_back();
      },
      "19 vertices have a motion, not 0 or 20");
  Checkpoint still = MakeCheckpoint();
  still.motion = {};
  EXPECT_TRUE(ParseCheckpoint(BytesOf(still), "c.bin").motion.size.empty());
}

TEST(Checkpoint, RefusesCountsThatAreOffByOne) {
  const Checkpoint checkpoint = MakeCheckpoint();
  const std::vector<uint8_t> good = BytesOf(checkpoint);
  for (const int off : {-1, 1}) {
    const uint64_t vertices = checkpoint.mesh.positions.size() + uint64_t(off);
    const uint64_t tets = checkpoint.mesh.tets.size() + uint64_t(off);
    EXPECT_THROW(ParseCheckpoint(With(good, kVertexCountAt, vertices), "c.bin"), DataError);
    EXPECT_THROW(ParseCheckpoint(With(good, kTetCountAt, tets), "c.bin"), DataError);
  }
}

TEST(Checkpoint, RefusesWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, infinity, -infinity}) {
    const auto refused = [bad](auto&& damage, const std::string& what) {
      Checkpoint checkpoint = MakeCheckpoint();
      damage(checkpoint, bad);
      const std::vector<uint8_t> bytes = BytesOf(checkpoint);
      ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {what});
    };
    refused([](Checkpoint& c, float x) { c.state.parameters[3 * 4 + 3] = x; },
            "parameter of vertex 3");
    refused([](Checkpoint& c, float x) { c.state.first_moment[0] = x; },
            "first moment of vertex 0");
    refused([](Checkpoint& c, float x) { c.state.second_moment.back() = x; },
            "second moment of vertex 19");
    refused([](Checkpoint& c, float x) { c.mesh.positions[7].y = x; }, "7");
    refused([](Checkpoint& c, float x) { c.seconds = x; }, "seconds");
  }
  EXPECT_THROW(ParseCheckpoint(With(BytesOf(MakeCheckpoint()), kSecondsAt, -1.0), "c.bin"),
               DataError);
}

TEST(Checkpoint, RefusesANegativeSecondMoment) {
  Checkpoint checkpoint = MakeCheckpoint();
  checkpoint.state.first_moment[2 * 4 + 1] = -1.0f;
  EXPECT_NO_THROW(ParseCheckpoint(BytesOf(checkpoint), "c.bin"));
  checkpoint.state.second_moment[2 * 4 + 1] = -1e-9f;
  const std::vector<uint8_t> bytes = BytesOf(checkpoint);
  ExpectError<DataError>([&] { ParseCheckpoint(bytes, "c.bin"); }, {"vertex 2", "negative"});
}

TEST(Checkpoint, RefusesAMeshThatDoesNotFitTogether) {
  const Checkpoint good = MakeCheckpoint();
  const auto refused = [&good](auto&& damage) {
    Checkpoint checkpoint = good;
    damage(checkpoint.mesh);
    const std::vector<uint8_t> bytes = BytesOf(checkpoint);
    EXPECT_THROW(ParseCheckpoint(bytes, "c.bin"), DataError);
  };
  refused([](TetMesh& m) { m.tets[1][2] = uint32_t(m.positions.size()); });
  refused([](TetMesh& m) { std::swap(m.tets[1][2], m.tets[1][3]); });
  refused([](TetMesh& m) { m.neighbors[0][0] = uint32_t(m.tets.size()); });
}

TEST(Checkpoint, RefusesAnotherMagic) {
  const std::vector<uint8_t> good = BytesOf(MakeCheckpoint());
  for (size_t at = 0; at < 8; ++at) {
    ExpectError<DataError>([&] { ParseCheckpoint(With(good, at, '?'), "c.bin"); },
                           {"c.bin", "not a checkpoint"});
  }
}

TEST(Checkpoint, SurvivesOrRefusesEveryFlippedByteOfItsHeadAndMesh) {
  const Checkpoint checkpoint = MakeCheckpoint();
  const std::vector<uint8_t> good = BytesOf(checkpoint);
  const size_t tets_at = kPositionsAt + 12 * checkpoint.mesh.positions.size();
  const size_t state_at = tets_at + 32 * checkpoint.mesh.tets.size();
  int refused = 0;
  for (size_t at = 0; at < state_at; ++at) {
    try {
      const Checkpoint read = ParseCheckpoint(With(good, at, uint8_t(good[at] ^ 0xFF)), "c.bin");
      EXPECT_EQ(read.mesh.positions.size(), checkpoint.mesh.positions.size());
      EXPECT_LT(at, tets_at) << "no other tets and neighbours fit";
    } catch (const DataError&) {
      ++refused;
    }
  }
  EXPECT_GE(refused, int(state_at - tets_at));
}

}  // namespace
}  // namespace tetrec
