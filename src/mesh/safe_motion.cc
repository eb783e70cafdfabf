// Moves of vertices that turn no tet inside out.
#include "mesh/safe_motion.h"

#include "core/error.h"
#include "core/parallel.h"
#include "geometry/orientation.h"

#include <atomic>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr int kMostHalvings = 4;
constexpr size_t kTetsPerCheck = 8192;
// A bound on the rounding of a determinant of differences of floats, computed in double, as a share
// of the product of its columns' absolute sums.
constexpr double kRoundingOfDeterminant = 1e-14;

using Positions = std::vector<glm::vec3>;

struct Determinant {
  double value;  // six times the signed volume
  bool is_sure;  // its sign is
};

double AbsoluteSum(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

Determinant DeterminantOf(const Positions& positions, const glm::uvec4& tet) {
  const glm::dvec3 origin(positions[tet[0]]);
  const glm::dvec3 a = glm::dvec3(positions[tet[1]]) - origin;
  const glm::dvec3 b = glm::dvec3(positions[tet[2]]) - origin;
  const glm::dvec3 c = glm::dvec3(positions[tet[3]]) - origin;
  const double value = glm::dot(glm::cross(a, b), c);
  return {value, std::abs(value) >
                     kRoundingOfDeterminant * AbsoluteSum(a) * AbsoluteSum(b) * AbsoluteSum(c)};
}

bool IsSound(const Positions& before, const Positions& after, const glm::uvec4& tet) {
  const Determinant now = DeterminantOf(after, tet);
  if (!(now.value >= kKeptVolumeShare * DeterminantOf(before, tet).value)) return false;
  if (now.is_sure) return now.value > 0;
  return Orientation(after[tet[0]], after[tet[1]], after[tet[2]], after[tet[3]]) == 1;
}

bool HasAny(const std::vector<uint8_t>& flags, const glm::uvec4& tet) {
  return (flags[tet[0]] | flags[tet[1]] | flags[tet[2]] | flags[tet[3]]) != 0;
}

// Flags the vertices of the tets that are not sound, of those that have a vertex of `changed`.
std::vector<uint8_t> VerticesOfUnsound(const TetMesh& mesh, const Positions& after,
                                       const std::vector<uint8_t>& changed) {
  std::vector<uint8_t> flags(after.size(), 0);
  ParallelFor(mesh.tets.size(), kTetsPerCheck, [&](size_t first, size_t last) {
    for (size_t t = first; t < last; ++t) {
      const glm::uvec4& tet = mesh.tets[t];
      if (!HasAny(changed, tet) || IsSound(mesh.positions, after, tet)) continue;
      for (int i = 0; i < 4; ++i) {
        std::atomic_ref<uint8_t>(flags[tet[i]]).store(1, std::memory_order_relaxed);
      }
    }
  });
  return flags;
}

}  // namespace

void MotionCounts::Add(const MotionCounts& other) {
  moved += other.moved;
  shortened += other.shortened;
  stopped += other.stopped;
}

SafeMotion MoveSafely(const TetMesh& mesh, std::span<const glm::vec3> moves) {
  const Positions& before = mesh.positions;
  const size_t count = before.size();
  TETREC_CHECK(moves.size() == count, "one move per vertex");
  Positions after(count);
  std::vector<uint8_t> changed(count), halvings(count, 0);
  for (size_t v = 0; v < count; ++v) {
    after[v] = before[v] + moves[v];
    changed[v] = uint8_t(moves[v] != glm::vec3(0.0f));
  }
  const std::vector<uint8_t> wanted = changed;
  // Ends: a tet that is not sound has a vertex that moved, and none is shortened for ever.
  for (bool any = true; any;) {
    const std::vector<uint8_t> unsound = VerticesOfUnsound(mesh, after, changed);
    any = false;
    for (size_t v = 0; v < count; ++v) {
      changed[v] = uint8_t(unsound[v] && after[v] != before[v]);
      if (!changed[v]) continue;
      any = true;
      const int halved = ++halvings[v];
      after[v] =
          halved > kMostHalvings ? before[v] : before[v] + std::ldexp(1.0f, -halved) * moves[v];
    }
  }
  MotionCounts counts;
  for (size_t v = 0; v < count; ++v) {
    if (!wanted[v]) continue;
    if (halvings[v] == 0) {
      ++counts.moved;
    } else if (halvings[v] <= kMostHalvings) {
      ++counts.shortened;
    } else {
      ++counts.stopped;
    }
  }
  return {std::move(after), counts};
}

}  // namespace tetrec
