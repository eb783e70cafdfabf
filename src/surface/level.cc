// Which level set of the density is the surface.
#include "surface/level.h"

#include "core/error.h"
#include "mesh/boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

namespace tetrec {
namespace {

// A ray's way through one tet: density is linear along it.
struct Segment {
  double length, density_in, density_out;
  double end;  // distance of its end from the march's start

  double OpticalDepth() const { return 0.5 * (density_in + density_out) * length; }
  Segment Reversed() const { return {length, density_out, density_in, end}; }
};

struct Face {
  glm::dvec3 normal;  // out of the tet, not unit
  glm::dvec3 point;
};

Face FaceOf(const TetMesh& mesh, uint32_t tet, int i) {
  const glm::uvec4& t = mesh.tets[tet];
  const glm::dvec3 a(mesh.positions[t[kFaceVertices[i][0]]]);
  const glm::dvec3 b(mesh.positions[t[kFaceVertices[i][1]]]);
  const glm::dvec3 c(mesh.positions[t[kFaceVertices[i][2]]]);
  return {glm::cross(b - a, c - a), a};
}

// Density at a point of the tet's affine frame.
double DensityAt(const RadianceField& field, uint32_t tet, const glm::dvec3& point) {
  double sum = 0, weights = 0;
  for (int i = 0; i < 4; ++i) {
    const Face face = FaceOf(field.mesh, tet, i);
    const double weight = std::max(0.0, glm::dot(face.normal, face.point - point));
    sum += weight * field.density[field.mesh.tets[tet][i]];
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

// Walks from tet to tet towards the point; nothing where it leaves the mesh or does not end.
std::optional<uint32_t> Locate(const TetMesh& mesh, const glm::dvec3& point, uint32_t tet) {
  for (size_t step = 0; step <= mesh.tets.size(); ++step) {
    int exit = -1;
    for (int k = 0; k < 4 && exit < 0; ++k) {
      // The face that is tried first changes, so that the walk does not circle in moved meshes.
      const int i = int((size_t(k) + step) % 4);
      const Face face = FaceOf(mesh, tet, i);
      if (glm::dot(face.normal, point - face.point) > 0) exit = i;
    }
    if (exit < 0) return tet;
    tet = mesh.neighbors[tet][exit];
    if (tet == kNoTet) return std::nullopt;
  }
  return std::nullopt;
}

// The segments from `start`, inside `tet`, along the unit direction to the hull or to max_distance.
// Nothing where rounding makes the march circle.
std::optional<std::vector<Segment>> March(const RadianceField& field, uint32_t tet,
                                          const glm::dvec3& start, const glm::dvec3& direction,
                                          double max_distance) {
  std::vector<Segment> segments;
  double distance = 0;
  double density = DensityAt(field, tet, start);
  uint32_t before = kNoTet;
  while (tet != kNoTet && distance < max_distance) {
    if (segments.size() > field.mesh.tets.size()) return std::nullopt;
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
    segments.push_back({end - distance, density, density_out, end});
    density = density_out;
    distance = end;
    before = tet;
    tet = field.mesh.neighbors[tet][exit];
  }
  return segments;
}

// Density where the optical depth reaches `remaining` inside the segment.
// s0 x + (s1 - s0) x^2 / 2 = r gives sigma(x)^2 = sigma_in^2 + 2 (sigma_out - sigma_in) r / length.
double DensityAtDepth(const Segment& s, double remaining) {
  const double squared =
      s.density_in * s.density_in + 2 * (s.density_out - s.density_in) * remaining / s.length;
  return std::sqrt(std::max(0.0, squared));
}

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double Unit() { return double(engine_() >> 11) * 0x1p-53; }
  glm::dvec3 In(const Bounds3& box) {
    const double x = Unit(), y = Unit(), z = Unit();
    return box.min + glm::dvec3(x, y, z) * box.Size();
  }
  glm::dvec3 Direction() {
    const double z = 2 * Unit() - 1, angle = 2 * std::numbers::pi * Unit();
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::mt19937_64 engine_;
};

struct Stop {
  bool lost = false;
  std::optional<double> density;  // where transmittance is one half, inside the bounds
};

// The ray from `eye` through `target`, a point of `tet`. Both halves are marched from the target,
// so neither the eye's tet nor the entry into the hull has to be found.
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
      // A segment's end is its far side from the target; the wall lies inside of it.
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
  // Its marches end where the mesh does.
  const std::string why = WhyNotConvex(field.mesh, BoundaryFaces(field.mesh));
  if (!why.empty()) {
    throw DataError(fmt::format("{}: no level can be found there; give --isovalue", why));
  }
  Random random(seed);
  HalfTransmittanceLevel result;
  std::vector<double> densities;
  uint32_t tet = 0;
  for (int r = 0; r < rays; ++r) {
    const glm::dvec3 target = random.In(bounds);
    const glm::dvec3 direction = random.Direction();
    const glm::dvec3 eye =
        cameras_in_world.empty()
            ? bounds.Center() + bounds.Diagonal() * direction
            : cameras_in_world[size_t(random.Unit() * double(cameras_in_world.size()))];
    ++result.rays;
    const std::optional<uint32_t> found = Locate(field.mesh, target, tet);
    if (!found || eye == target) {
      ++result.lost_rays;
      continue;
    }
    tet = *found;
    const Stop stop = FollowRay(field, bounds, eye, target, tet);
    result.lost_rays += stop.lost;
    if (stop.density) densities.push_back(*stop.density);
  }
  result.opaque_rays = densities.size();
  if (densities.size() * 100 < result.rays || densities.empty()) {
    throw DataError(fmt::format(
        "only {} of {} rays are stopped inside the subject's bounds: the field is too thin "
        "for a surface; optimise longer or give --isovalue",
        densities.size(), result.rays));
  }
  const auto level = densities.begin() + ptrdiff_t(densities.size() * 3 / 4);
  std::nth_element(densities.begin(), level, densities.end());
  result.isovalue = *level;
  return result;
}

}  // namespace tetrec
