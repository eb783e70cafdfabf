// The state of a run on disk, from which a stopped or killed run continues.
#include "optimize/checkpoint.h"

#include "core/error.h"
#include "core/error_context.h"
#include "core/file.h"
#include "geometry/rotation.h"
#include "render/field_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

// Bounds the largest entry of R^T R - I. The rounding of many small turns adds up.
constexpr double kRotationTolerance = 1e-6;
constexpr std::array<char, 8> kMagic = {'T', 'E', 'T', 'R', 'E', 'C', 'K', 'I'};

constexpr size_t kChecksumBytes = 64;  // hexadecimal SHA-256 of all before it

void CheckMagic(ByteReader& reader) {
  if (reader.Read<std::array<char, 8>>("magic") == kMagic) return;
  throw DataError(fmt::format("{}: is not a checkpoint of this version of Tetrec", reader.name()));
}

// `width`: values per row.
void CheckFinite(const std::vector<float>& values, int width, FieldStorage storage,
                 const std::string& name, const char* what) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw DataError(fmt::format("{}: {} of {} {} is not finite", name, what, RowName(storage),
                                  i / size_t(width)));
    }
  }
}

// Updates take their root.
void CheckNotNegative(const std::vector<float>& second_moment, const FieldLayout& layout,
                      const std::string& name) {
  for (size_t i = 0; i < second_moment.size(); ++i) {
    if (second_moment[i] < 0) {
      throw DataError(fmt::format("{}: a second moment of {} {} is negative", name,
                                  RowName(layout.storage), i / size_t(layout.SecondMoments())));
    }
  }
}

void CheckValues(const FieldState& state, const std::string& name) {
  const FieldLayout& layout = state.layout;
  CheckFinite(state.parameters, layout.Components(), layout.storage, name, "a parameter");
  CheckFinite(state.first_moment, FieldLayout::FirstMoments(), layout.storage, name,
              "a first moment");
  CheckFinite(state.second_moment, layout.SecondMoments(), layout.storage, name, "a second moment");
  CheckNotNegative(state.second_moment, layout, name);
}

// As they are in the file.
static_assert(sizeof(HarmonicsState) == 3 * sizeof(uint32_t));
static_assert(sizeof(ViewExposure) == 6 * sizeof(double));
static_assert(sizeof(ExposureSums) == 15 * sizeof(double));
static_assert(sizeof(CorrectedPose) == 13 * sizeof(double));
static_assert(sizeof(RowRates) == 3 * sizeof(float));
static_assert(sizeof(MotionCounts) == 3 * sizeof(uint64_t));
static_assert(sizeof(ErrorSum) == 2 * sizeof(double));
static_assert(sizeof(GrowthStep) == 11 * sizeof(uint64_t));
static_assert(sizeof(ConvergenceState) == 4 * sizeof(uint64_t));

void WritePace(ByteWriter& writer, const DevicePace& pace) {
  writer.Write(uint64_t(pace.rays_per_step));
  writer.Write(uint64_t(pace.views_per_batch));
  writer.Write(pace.speed);
  writer.Write(pace.steps_per_motion);
}

DevicePace ReadPace(ByteReader& reader, const std::string& name) {
  DevicePace pace;
  const uint64_t rays = reader.Read<uint64_t>("rays per step");
  if (rays == 0 || rays > 1u << 30) {
    throw DataError(fmt::format("{}: {} rays per step are not possible", name, rays));
  }
  pace.rays_per_step = int(rays);
  pace.views_per_batch = reader.Read<uint64_t>("views per batch");
  pace.speed = reader.Read<double>("speed");
  pace.steps_per_motion = reader.Read<uint64_t>("steps per motion");
  return pace;
}

TrialState ReadTrial(ByteReader& reader, const std::string& name, const char* what) {
  const uint32_t state = reader.Read<uint32_t>(what);
  if (state > uint32_t(TrialState::kUsed)) {
    throw DataError(fmt::format("{}: the trial of {} is {}, not 0, 1 or 2", name, what, state));
  }
  return TrialState(state);
}

MotionState ReadMotion(ByteReader& reader, size_t vertices, const std::string& name) {
  MotionState motion;
  motion.motions = reader.Read<uint64_t>("motions");
  motion.counts = reader.Read<MotionCounts>("counts of moves");
  const uint64_t count = reader.Read<uint64_t>("moving vertices");
  if (count != 0 && count != vertices) {
    throw DataError(
        fmt::format("{}: {} vertices have a motion, not 0 or {}", name, count, vertices));
  }
  motion.first_moment = reader.ReadArray<glm::vec3>(count, "first moments of positions");
  motion.second_moment = reader.ReadArray<glm::vec3>(count, "second moments of positions");
  motion.size = reader.ReadArray<float>(count, "sizes of vertices");
  motion.room = reader.ReadArray<float>(count, "room of vertices");
  return motion;
}

bool IsNotNegative(float value) { return std::isfinite(value) && value >= 0; }

// Motions take the root of second moments and are bounded by sizes and room.
void CheckMotion(const MotionState& motion, const std::string& name) {
  for (size_t v = 0; v < motion.size.size(); ++v) {
    const glm::vec3& first = motion.first_moment[v];
    const glm::vec3& second = motion.second_moment[v];
    const bool finite = std::isfinite(first.x) && std::isfinite(first.y) && std::isfinite(first.z);
    if (!finite || !IsNotNegative(second.x) || !IsNotNegative(second.y) ||
        !IsNotNegative(second.z) || !IsNotNegative(motion.size[v]) ||
        !IsNotNegative(motion.room[v])) {
      throw DataError(fmt::format("{}: the motion of vertex {} is not possible", name, v));
    }
  }
}

void WriteViews(ByteWriter& writer, const std::vector<ErrorSum>& views) {
  writer.Write(uint64_t(views.size()));
  writer.WriteArray(std::span<const ErrorSum>(views));
}

// What the judging pictures of each view say.
std::vector<ErrorSum> ReadViews(ByteReader& reader, const std::string& name) {
  std::vector<ErrorSum> views =
      reader.ReadArray<ErrorSum>(reader.Read<uint64_t>("judging view count"), "judging views");
  for (const ErrorSum& view : views) {
    if (!(view.squares >= 0 && view.rays > 0 && std::isfinite(view.squares + view.rays))) {
      throw DataError(fmt::format("{}: the error {} of {} judging rays is not possible", name,
                                  view.squares, view.rays));
    }
  }
  return views;
}

void WriteRounds(ByteWriter& writer, const RoundsState& state) {
  writer.Write(state.rounds);
  writer.Write(state.ended);
  writer.Write(state.settled);
  writer.Write(state.best_psnr);
  WriteViews(writer, state.last_views);
  writer.Write(uint64_t(state.steps.size()));
  writer.WriteArray(std::span<const GrowthStep>(state.steps));
}

RoundsState ReadRounds(ByteReader& reader, const std::string& name) {
  RoundsState state;
  state.rounds = reader.Read<uint32_t>("rounds");
  state.ended = reader.Read<uint32_t>("end of rounds");
  state.settled = reader.Read<uint64_t>("settled iteration");
  state.best_psnr = reader.Read<double>("best PSNR");
  state.last_views = ReadViews(reader, name);
  state.steps = reader.ReadArray<GrowthStep>(reader.Read<uint64_t>("growth step count"), "growth");
  for (const GrowthStep& step : state.steps) {
    const double sum = step.seconds + step.psnr + step.gain + step.gain_standard_error;
    if (!std::isfinite(sum) || step.decision > GrowthDecision::kTooLate) {
      throw DataError(
          fmt::format("{}: the growth after {} steps is not possible", name, step.iteration));
    }
  }
  if (!std::isfinite(state.best_psnr)) {
    throw DataError(fmt::format("{}: best PSNR {} is not finite", name, state.best_psnr));
  }
  if (state.ended > 1) {
    throw DataError(fmt::format("{}: the end of rounds is {}, not 0 or 1", name, state.ended));
  }
  return state;
}

void WriteCoarsening(ByteWriter& writer, const CoarseningState& state) {
  writer.Write(state.ended);
  writer.Write(state.has_failed);
  writer.Write(state.kept_share);
  writer.Write(state.finest_vertices);
  WriteViews(writer, state.reference);
}

CoarseningState ReadCoarsening(ByteReader& reader, const std::string& name) {
  CoarseningState state;
  state.ended = reader.Read<uint32_t>("end of coarsening");
  state.has_failed = reader.Read<uint32_t>("failure of coarsening");
  state.kept_share = reader.Read<double>("kept share");
  state.finest_vertices = reader.Read<uint64_t>("finest vertices");
  state.reference = ReadViews(reader, name);
  if (state.ended > 1 || state.has_failed > 1 || !(state.kept_share > 0 && state.kept_share <= 1)) {
    throw DataError(fmt::format("{}: the state of coarsening is {}, {}, {}, which is not possible",
                                name, state.ended, state.has_failed, state.kept_share));
  }
  return state;
}

ExposureState ReadExposure(ByteReader& reader) {
  const uint64_t views = reader.Read<uint64_t>("exposure count");
  return {reader.ReadArray<ViewExposure>(views, "exposures"),
          reader.ReadArray<ExposureSums>(views, "exposure sums")};
}

PoseState ReadPoses(ByteReader& reader) {
  PoseState state;
  state.sweeps = reader.Read<uint32_t>("sweeps");
  state.poses = reader.ReadArray<CorrectedPose>(reader.Read<uint64_t>("pose count"), "poses");
  return state;
}

StrayState ReadStray(ByteReader& reader, const std::string& name) {
  StrayState state;
  state.looks = reader.Read<uint32_t>("looks for stray photos");
  const uint64_t count = reader.Read<uint64_t>("stray count");
  state.left_out = reader.ReadArray<uint8_t>(count, "stray photos");
  state.tried_ratio = reader.ReadArray<float>(count, "tried ratios");
  for (size_t photo = 0; photo < state.left_out.size(); ++photo) {
    if (state.left_out[photo] > 1) {
      throw DataError(fmt::format("{}: the flag of photo {} is {}; expected 0 or 1", name, photo,
                                  state.left_out[photo]));
    }
    const float ratio = state.tried_ratio[photo];
    if (std::isfinite(ratio) && ratio >= 0) continue;
    throw DataError(fmt::format("{}: the ratio of errors of photo {} is {}; expected 0 or more",
                                name, photo, ratio));
  }
  return state;
}

void CheckPoses(const PoseState& state, const std::string& name) {
  const auto fail = [&](size_t view, const char* what) {
    throw DataError(fmt::format("{}: the {} of pose {} is not possible", name, what, view));
  };
  for (size_t view = 0; view < state.poses.size(); ++view) {
    const CorrectedPose& pose = state.poses[view];
    if (!(DistanceFromRotation(pose.cam_from_world.rotation) < kRotationTolerance)) {
      fail(view, "rotation");
    }
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(pose.cam_from_world.translation[i])) fail(view, "translation");
    }
    if (!std::isfinite(pose.depth) || pose.depth < 0) fail(view, "depth");
  }
}

void CheckHarmonics(const HarmonicsState& harmonics, const std::string& name) {
  if (harmonics.unlocked <= uint32_t(kMostHarmonicsDegree) &&
      harmonics.judged <= harmonics.unlocked && harmonics.closed <= 1) {
    return;
  }
  throw DataError(fmt::format("{}: {} degrees of harmonics unlocked, {} judged, closed {}", name,
                              harmonics.unlocked, harmonics.judged, harmonics.closed));
}

void CheckExposure(const ExposureState& exposure, const std::string& name) {
  const auto fail = [&](size_t view, const char* what) {
    throw DataError(fmt::format("{}: {} of exposure {} is not possible", name, what, view));
  };
  for (size_t view = 0; view < exposure.exposures.size(); ++view) {
    for (int c = 0; c < 3; ++c) {
      const double gain = exposure.exposures[view].gain[c];
      if (!std::isfinite(gain) || gain <= 0) fail(view, "a gain");
      if (!std::isfinite(exposure.exposures[view].offset[c])) fail(view, "an offset");
      const GainOffsetSums& sums = exposure.sums[view][size_t(c)];
      const bool finite = std::isfinite(sums.xw) && std::isfinite(sums.yw) &&
                          std::isfinite(sums.yx) && std::isfinite(sums.ww) &&
                          std::isfinite(sums.xx);
      if (!finite || sums.ww < 0 || sums.xx < 0) fail(view, "a sum");
    }
  }
}

}  // namespace

void WriteCheckpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  ByteWriter head, middle, tail;
  head.Write(kMagic);
  head.Write(checkpoint.iteration);
  head.Write(checkpoint.seconds);
  head.Write(checkpoint.rays);
  WritePace(head, checkpoint.pace);
  WriteRounds(head, checkpoint.rounds);
  WriteCoarsening(head, checkpoint.coarsening);
  head.Write(checkpoint.convergence);
  head.Write(checkpoint.metrics_bytes);
  head.Write(checkpoint.harmonics);
  head.Write(checkpoint.fine_rays);
  head.Write(uint64_t(checkpoint.mesh.positions.size()));
  head.Write(uint64_t(checkpoint.mesh.tets.size()));
  AppendLayout(head, checkpoint.state.layout);
  middle.Write(checkpoint.share_of_rates);
  middle.Write(checkpoint.motion.motions);
  middle.Write(checkpoint.motion.counts);
  middle.Write(uint64_t(checkpoint.motion.size.size()));
  tail.Write(uint64_t(checkpoint.exposure.exposures.size()));
  tail.WriteArray(std::span<const ViewExposure>(checkpoint.exposure.exposures));
  tail.WriteArray(std::span<const ExposureSums>(checkpoint.exposure.sums));
  tail.Write(checkpoint.poses.sweeps);
  tail.Write(uint64_t(checkpoint.poses.poses.size()));
  tail.WriteArray(std::span<const CorrectedPose>(checkpoint.poses.poses));
  tail.Write(checkpoint.stray.looks);
  tail.Write(uint64_t(checkpoint.stray.left_out.size()));
  tail.WriteArray(std::span<const uint8_t>(checkpoint.stray.left_out));
  tail.WriteArray(std::span<const float>(checkpoint.stray.tried_ratio));

  std::vector<std::span<const uint8_t>> pieces = {head.bytes(),
                                                  BytesOf(checkpoint.mesh.positions),
                                                  BytesOf(checkpoint.mesh.tets),
                                                  BytesOf(checkpoint.mesh.neighbors),
                                                  BytesOf(checkpoint.state.parameters),
                                                  BytesOf(checkpoint.state.first_moment),
                                                  BytesOf(checkpoint.state.second_moment),
                                                  BytesOf(checkpoint.row_rates),
                                                  middle.bytes(),
                                                  BytesOf(checkpoint.motion.first_moment),
                                                  BytesOf(checkpoint.motion.second_moment),
                                                  BytesOf(checkpoint.motion.size),
                                                  BytesOf(checkpoint.motion.room),
                                                  tail.bytes()};
  const std::string checksum = Sha256(pieces);
  pieces.push_back({reinterpret_cast<const uint8_t*>(checksum.data()), checksum.size()});
  WritePieces(path, pieces);
}

Checkpoint ParseCheckpoint(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  CheckMagic(reader);
  Checkpoint result;
  result.iteration = reader.Read<uint64_t>("iteration");
  result.seconds = reader.Read<double>("seconds");
  result.rays = reader.Read<uint64_t>("rays");
  result.pace = ReadPace(reader, name);
  result.rounds = ReadRounds(reader, name);
  result.coarsening = ReadCoarsening(reader, name);
  result.convergence = reader.Read<ConvergenceState>("convergence");
  result.metrics_bytes = reader.Read<uint64_t>("metrics bytes");
  result.harmonics = reader.Read<HarmonicsState>("harmonics");
  result.fine_rays = ReadTrial(reader, name, "fine rays");
  const uint64_t vertices = reader.Read<uint64_t>("vertex count");
  const uint64_t tets = reader.Read<uint64_t>("tet count");
  FieldState& state = result.state;
  state.layout = TakeLayout(reader);
  const FieldLayout& layout = state.layout;
  result.mesh.positions = reader.ReadArray<glm::vec3>(vertices, "positions");
  result.mesh.tets = reader.ReadArray<glm::uvec4>(tets, "tets");
  result.mesh.neighbors = reader.ReadArray<glm::uvec4>(tets, "neighbours");
  const uint64_t rows = RowCount(result.mesh, layout.storage);
  state.parameters = reader.ReadArray<float>(rows * uint64_t(layout.Components()), "parameters");
  state.first_moment =
      reader.ReadArray<float>(rows * uint64_t(FieldLayout::FirstMoments()), "first moments");
  state.second_moment =
      reader.ReadArray<float>(rows * uint64_t(layout.SecondMoments()), "second moments");
  result.row_rates = reader.ReadArray<RowRates>(rows, "rates of rows");
  result.share_of_rates = reader.Read<double>("share of rates");
  result.motion = ReadMotion(reader, vertices, name);
  result.exposure = ReadExposure(reader);
  result.poses = ReadPoses(reader);
  result.stray = ReadStray(reader, name);
  reader.ExpectEnd();
  if (!std::isfinite(result.seconds) || result.seconds < 0) {
    throw DataError(fmt::format("{}: seconds {} is not a time", name, result.seconds));
  }
  if (!(result.share_of_rates > 0 && result.share_of_rates <= 1)) {
    throw DataError(fmt::format("{}: {} is not a share of the rates", name, result.share_of_rates));
  }
  if (!std::isfinite(result.convergence.best_psnr)) {
    throw DataError(fmt::format("{}: the PSNR {} of the convergence is not finite", name,
                                result.convergence.best_psnr));
  }
  CheckHarmonics(result.harmonics, name);
  CheckValues(state, name);
  CheckMotion(result.motion, name);
  CheckExposure(result.exposure, name);
  CheckPoses(result.poses, name);
  NamingFile(name, [&] {
    CheckRowRates(result.row_rates, rows);
    CheckTetMesh(result.mesh, Orientations::kAny);  // whoever takes the mesh decides about them
    // Among inverted tets, vertices may even be outside.
    if (CountDegenerateTets(result.mesh) == 0) CheckConvexDomain(result.mesh);
  });
  return result;
}

Checkpoint ReadCheckpoint(const std::filesystem::path& path) {
  return Advising("force a fresh run", [&] {
    const std::vector<uint8_t> file = ReadBytes(path);
    const std::string name = path.string();
    ByteReader start(file, name);
    CheckMagic(start);
    const size_t size = file.size() - std::min(file.size(), kChecksumBytes);
    const std::span<const uint8_t> body = std::span(file).first(size),
                                   checksum = std::span(file).subspan(size);
    if (Sha256(body) != std::string(checksum.begin(), checksum.end())) {
      throw DataError(fmt::format("{}: is damaged", name));
    }
    return ParseCheckpoint(body, name);
  });
}

}  // namespace tetrec
