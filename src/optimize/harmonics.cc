// View-dependent colour in training.
#include "optimize/harmonics.h"

#include "core/parallel.h"
#include "render/seen_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

// The growth of a run at which degrees 1, 2 and 3 are unlocked, and at which the first two are
// judged, before the judging pictures are learned (ScheduleOptions::last_judging).
constexpr std::array<double, kMostHarmonicsDegree> kUnlock = {0.15, 0.35, 0.5};
constexpr std::array<double, 2> kJudge = {0.3, 0.47};

// The mean of each function over the directions from which the cameras look at a place.
std::array<double, 15> MeanHarmonics(const glm::dvec3& place, std::span<const glm::dvec3> centers) {
  std::array<double, 15> mean{};
  for (const glm::dvec3& center : centers) {
    const std::array<double, 15> basis = HarmonicsAt(DirectionTo(place, center));
    for (size_t k = 0; k < mean.size(); ++k) mean[k] += basis[k] / double(centers.size());
  }
  return mean;
}

}  // namespace

size_t PhotosForDegree(uint32_t degree) { return size_t(degree + 1) * (degree + 1); }

uint32_t HighestDegree(HarmonicsChoice choice, size_t photos) {
  if (choice != HarmonicsChoice::kAuto) return uint32_t(choice);
  uint32_t degree = 0;
  while (degree < kUnlock.size() && photos >= PhotosForDegree(degree + 1)) ++degree;
  return degree;
}

bool IsJudged(uint32_t degree) { return degree <= kJudge.size(); }

HarmonicsStep NextHarmonicsStep(HarmonicsChoice choice, size_t photos, const HarmonicsState& state,
                                double growth) {
  if (choice == HarmonicsChoice::kAuto && state.unlocked > state.judged &&
      IsJudged(state.unlocked)) {
    return growth >= kJudge[state.unlocked - 1] ? HarmonicsStep::kJudge : HarmonicsStep::kNone;
  }
  if (state.closed != 0 || state.unlocked >= HighestDegree(choice, photos)) {
    return HarmonicsStep::kNone;
  }
  return growth >= kUnlock[state.unlocked] ? HarmonicsStep::kUnlock : HarmonicsStep::kNone;
}

bool IsWorthHarmonics(double with, double without) {
  constexpr double kStep = 1.0 / 255;
  const double gain = std::pow(10, -without / 10) - std::pow(10, -with / 10);
  return with > without + 0.05 && gain > kStep * kStep;
}

FieldState WithoutHighestDegree(const TetMesh& mesh, const FieldState& state,
                                const PhotoSight& sight) {
  const int degree = state.layout.HarmonicsDegree();
  const std::vector<glm::dvec3> all_centers = sight.Centers();
  const std::vector<glm::vec3> places = PlacesOfRows(mesh, state.layout.storage);
  const size_t components = size_t(state.layout.Components());
  const size_t first = size_t(state.layout.OffsetOf(kHarmonicsName));
  FieldState means = state;
  const auto add_mean = [&](size_t row) {
    const glm::dvec3 place(places[row]);
    const std::vector<glm::dvec3> seeing = sight.CentersThatSee(place);
    const std::array<double, 15> mean = MeanHarmonics(place, seeing.empty() ? all_centers : seeing);
    float* values = &means.parameters[row * components];
    for (size_t k = size_t(HarmonicsCount(degree - 1)); k < size_t(HarmonicsCount(degree)); ++k) {
      for (size_t c = 0; c < 3; ++c) {
        values[kColorOffset + c] += float(mean[k]) * values[first + 3 * k + c];
      }
    }
    for (size_t c = 0; c < 3; ++c) {
      values[kColorOffset + c] = std::clamp(values[kColorOffset + c], 0.0f, 1.0f);
    }
  };
  ParallelFor(places.size(), 256, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) add_mean(row);
  });
  return WithHarmonics(means, degree - 1);
}

}  // namespace tetrec
