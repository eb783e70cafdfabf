// The choice of the density level that is the surface.
#include "surface/level.h"

#include "core/error.h"
#include "core/quantile.h"
#include "field/density_at.h"
#include "geometry/random_vectors.h"
#include "mesh/boundary.h"
#include "mesh/locate.h"
#include "shared/segment_cut.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace tetrec {
namespace {

// The part of a ray inside one tet; density is linear along it.
struct Segment {
  double length, density_in, density_out;
  double end;  // distance from the start of the march to the end of this segment

  double OpticalDepth() const { return 0.5 * (density_in + density_out) * length; }
  Segment Reversed() const { return {length, density_out, density_in, end}; }
};

// Appends a tet's part of a ray; `in` and `out` are values of density, which may be negative: where
// they are, density is 0.
void AppendParts(std::vector<Segment>& segments, double length, double in, double out, double end) {
  const SegmentCut<double> cut = CutAtZero(in, out);
  const double begin = end - length, begins = cut.begin * length, ends = cut.end * length;
  if (cut.begin > 0) segments.push_back({begins, 0, 0, begin + begins});
  if (cut.end > cut.begin) {
    segments.push_back({ends - begins, DensityOf(in), DensityOf(out), begin + ends});
  }
  if (cut.end < 1) segments.push_back({length - ends, 0, 0, end});
}

struct Face {
  glm::dvec3 normal;  // points out of the tet, not of unit length
  glm::dvec3 point;
};

Face FaceOf(const TetMesh& mesh, uint32_t tet, int i) {
  const glm::uvec4& t = mesh.tets[tet];
  const glm::dvec3 a(mesh.positions[t[kFaceVertices[i][0]]]);
  const glm::dvec3 b(mesh.positions[t[kFaceVertices[i][1]]]);
  const glm::dvec3 c(mesh.positions[t[kFaceVertices[i][2]]]);
  return {glm::cross(b - a, c - a), a};
}

// The segments from `start`, inside `tet`, along the unit direction to the hull or to max_distance.
// Nothing if rounding makes the march circle.
std::optional<std::vector<Segment>> March(const RadianceField& field, uint32_t tet,
                                          const glm::dvec3& start, const glm::dvec3& direction,
                                          double max_distance) {
  std::vector<Segment> segments;
  double distance = 0;
  double density = DensityAt(field, tet, start);
  uint32_t before = kNoTet;
  while (tet != kNoTet && distance < max_distance) {
    if (segments.size() > 3 * field.mesh.tets.size()) return std::nullopt;
    int exit = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i) {
      if (before != kNoTet && field.mesh.neighbors[tet][i] == before) continue;
      const Face face = FaceOf(field.mesh, tet, i);
      const double along = glm::dot(face.normal, direction);
      if (along <= 0) continue;
      const double hit = glm::dot(face.normal, face.point - start) / along;
      if (hit < nearest) {
        nearest = hit;
        exit = i;
      }
    }
    if (exit < 0) return std::nullopt;
    const double end = std::clamp(nearest, distance, max_distance);
    const double density_out = DensityAt(field, tet, start + end * direction);
    AppendParts(segments, end - distance, density, density_out, end);
    density = density_out;
    distance = end;
    before = tet;
    tet = field.mesh.neighbors[tet][exit];
  }
  return segments;
}

// Density at the point of the segment where the optical depth reaches `remaining`.
// s0 x + (s1 - s0) x^2 / 2 = r gives sigma(x)^2 = sigma_in^2 + 2 (sigma_out - sigma_in) r / length.
double DensityAtDepth(const Segment& s, double remaining) {
  const double squared =
      s.density_in * s.density_in + 2 * (s.density_out - s.density_in) * remaining / s.length;
  return std::sqrt(std::max(0.0, squared));
}

struct Stop {
  bool lost = false;
  std::optional<double> density;  // at transmittance one half, if that is inside the bounds
};

// Follows the ray from `eye` through `target`, a point of `tet`. Both halves are marched from the
// target, so that neither the eye's tet nor the entry into the hull is needed.
Stop FollowRay(const RadianceField& field, const Bounds3& bounds, const glm::dvec3& eye,
               const glm::dvec3& target, uint32_t tet) {
  const double distance = glm::distance(eye, target);
  const glm::dvec3 direction = (target - eye) / distance;
  auto before = March(field, tet, target, -direction, distance);
  const auto behind = March(field, tet, target, direction, std::numeric_limits<double>::infinity());
  if (!before || !behind) return {true, {}};
  double remaining = std::numbers::ln2;
  for (auto s = before->rbegin(); s != before->rend(); ++s) {
    const double depth = s->OpticalDepth();
    if (depth >= remaining) {
      // The wall is somewhere inside the segment, which ends at its side away from the target.
      const bool inside = bounds.Contains(target - (s->end - 0.5 * s->length) * direction);
      return {false,
              inside ? std::optional(DensityAtDepth(s->Reversed(), remaining)) : std::nullopt};
    }
    remaining -= depth;
  }
  for (const Segment& s : *behind) {
    const double depth = s.OpticalDepth();
    if (depth >= remaining) {
      const bool inside = bounds.Contains(target + (s.end - 0.5 * s.length) * direction);
      return {false, inside ? std::optional(DensityAtDepth(s, remaining)) : std::nullopt};
    }
    remaining -= depth;
  }
  return {};
}

}  // namespace

HalfTransmittanceLevel FindHalfTransmittanceLevel(const RadianceField& field, const Bounds3& bounds,
                                                  std::span<const glm::dvec3> cameras_in_world,
                                                  int rays, uint64_t seed) {
  // A march ends at the boundary and would miss whatever comes after a gap.
  const std::string why = WhyNotConvex(field.mesh, BoundaryFaces(field.mesh));
  if (!why.empty()) {
    throw DataError(fmt::format("{}: no level can be found there; give an isovalue", why));
  }
  MersenneRandom random(seed);
  HalfTransmittanceLevel result;
  std::vector<double> densities;
  uint32_t tet = 0;
  for (int r = 0; r < rays; ++r) {
    const glm::dvec3 target = bounds.min + RandomInUnitCube(random) * bounds.Size();
    const glm::dvec3 direction = RandomDirection(random);
    const glm::dvec3 eye =
        cameras_in_world.empty()
            ? bounds.Center() + bounds.Diagonal() * direction
            : cameras_in_world[size_t(random.Uniform() * double(cameras_in_world.size()))];
    ++result.rays;
    const uint32_t found = FindTet(field.mesh, target, tet, /*is_convex=*/true);
    if (found == kNoTet || eye == target) {
      ++result.lost_rays;
      continue;
    }
    tet = found;
    const Stop stop = FollowRay(field, bounds, eye, target, tet);
    result.lost_rays += stop.lost;
    if (stop.density) densities.push_back(*stop.density);
  }
  result.opaque_rays = densities.size();
  if (densities.size() * 100 < result.rays || densities.empty()) {
    throw DataError(fmt::format(
        "only {} of {} rays are stopped inside the subject's bounds: the field is too thin "
        "for a surface; optimise longer or give an isovalue",
        densities.size(), result.rays));
  }
  const size_t rank = densities.size() * 3 / 4;
  result.isovalue = ValueOfRank(std::move(densities), rank);
  return result;
}

}  // namespace tetrec
