// One ray through a field, in float or double, without neighbour links or rounding tricks: the
// building blocks of the reference renderer.
#pragma once

#include "field/radiance_field.h"
#include "render/integral.h"
#include "render/reference/tet_boxes.h"
#include "shared/integral.glsl.h"
#include "shared/segment_cut.glsl.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

template <class Real>
using Vec3 = glm::vec<3, Real, glm::defaultp>;
template <class Real>
using Vec4 = glm::vec<4, Real, glm::defaultp>;

template <class Real>
struct WorldRay {
  Vec3<Real> origin, direction;  // world, direction of length 1
};

constexpr int kNoFace = -1;

// The part of a ray inside one tet, with the barycentric weights of its ends.
template <class Real>
struct RaySegment {
  Real begin, end;  // along the ray [world units]
  uint32_t tet;
  Vec4<Real> begin_weights, end_weights;
  int begin_face = kNoFace, end_face = kNoFace;  // kNoFace: at the ray's origin
};

// The plane through three vertices, computed in the order of their ids: the two tets at a face get
// the same rounding, so their segments join without gap or overlap.
template <class Real>
struct FacePlane {
  Vec3<Real> normal, point;
};

template <class Real>
FacePlane<Real> PlaneOf(const TetMesh& mesh, const glm::uvec4& tet, int face) {
  std::array<uint32_t, 3> ids;
  for (int i = 0; i < 3; ++i) ids[i] = tet[(face + 1 + i) % 4];
  std::sort(ids.begin(), ids.end());
  const Vec3<Real> a(mesh.positions[ids[0]]), b(mesh.positions[ids[1]]), c(mesh.positions[ids[2]]);
  return {glm::cross(b - a, c - a), a};
}

// Cuts the ray's part ahead of its origin with the four planes. Empty if begin >= end.
template <class Real>
RaySegment<Real> CutTet(const TetMesh& mesh, uint32_t t, const WorldRay<Real>& ray) {
  const glm::uvec4& tet = mesh.tets[t];
  RaySegment<Real> segment{Real(0), std::numeric_limits<Real>::infinity(), t, {}, {}};
  Vec4<Real> weight_at_origin(Real(0)), weight_slope(Real(0));
  for (int i = 0; i < 4; ++i) {
    const FacePlane<Real> plane = PlaneOf<Real>(mesh, tet, i);
    const Real at_vertex = glm::dot(plane.normal, Vec3<Real>(mesh.positions[tet[i]]) - plane.point);
    const Real at_origin = glm::dot(plane.normal, ray.origin - plane.point);
    const Real slope = glm::dot(plane.normal, ray.direction);
    weight_at_origin[i] = at_origin / at_vertex;
    weight_slope[i] = slope / at_vertex;
    if (weight_slope[i] > 0) {
      if (-at_origin / slope > segment.begin) {
        segment.begin = -at_origin / slope;
        segment.begin_face = i;
      }
    } else if (weight_slope[i] < 0) {
      if (-at_origin / slope < segment.end) {
        segment.end = -at_origin / slope;
        segment.end_face = i;
      }
    } else {
      // Parallel to the face. A ray inside its plane belongs to the side that a fixed direction
      // points to.
      const Real side =
          glm::dot(plane.normal, Vec3<Real>(Real(0.51), Real(0.62), Real(0.59))) / at_vertex;
      const bool outside = weight_at_origin[i] < 0 || (weight_at_origin[i] == 0 && side < 0);
      if (outside) segment.end = Real(-1);
    }
  }
  segment.begin_weights = weight_at_origin + segment.begin * weight_slope;
  segment.end_weights = weight_at_origin + segment.end * weight_slope;
  return segment;
}

template <class Real>
Real InterpolateDensity(const RadianceField& field, uint32_t tet, const Vec4<Real>& weights) {
  if (field.storage == FieldStorage::kCell) return Real(field.density[tet]);
  Real density(0);
  for (int i = 0; i < 4; ++i) density += weights[i] * Real(field.density[field.mesh.tets[tet][i]]);
  return density;
}

template <class Real>
Vec3<Real> InterpolateColor(const RadianceField& field, uint32_t tet, const Vec4<Real>& weights) {
  if (field.storage == FieldStorage::kCell) return Vec3<Real>(field.color_srgb[tet]);
  Vec3<Real> color(Real(0));
  for (int i = 0; i < 4; ++i) {
    color += weights[i] * Vec3<Real>(field.color_srgb[field.mesh.tets[tet][i]]);
  }
  return color;
}

// The part of a segment in which density is positive: its ends as shares of the segment, its
// length, s0 and s1 of segment.glsl.h, and the colours at its ends.
template <class Real>
struct SegmentEnds {
  SegmentCut<Real> cut;
  Real length;
  Real s0, s1;
  Vec3<Real> c0, c1;

  Real depth() const { return Real(0.5) * (s0 + s1); }  // optical
};

template <class Real>
SegmentEnds<Real> EndsOf(const RadianceField& field, const RaySegment<Real>& segment) {
  const Real d0 = InterpolateDensity(field, segment.tet, segment.begin_weights);
  const Real d1 = InterpolateDensity(field, segment.tet, segment.end_weights);
  const Vec3<Real> c0 = InterpolateColor(field, segment.tet, segment.begin_weights);
  const Vec3<Real> c1 = InterpolateColor(field, segment.tet, segment.end_weights);
  const SegmentCut<Real> cut = CutAtZero(d0, d1);
  const Real length = (cut.end - cut.begin) * (segment.end - segment.begin);
  return {cut,
          length,
          length * DensityOf(d0),
          length * DensityOf(d1),
          glm::mix(c0, c1, cut.begin),
          glm::mix(c0, c1, cut.end)};
}

// Front to back, up to and including the tet in which the optical depth reaches `stop_depth`.
template <class Real>
std::vector<RaySegment<Real>> CutMesh(const RadianceField& field, const TetBoxes& boxes,
                                      const WorldRay<Real>& ray, Real stop_depth) {
  std::vector<RaySegment<Real>> segments;
  ForEachTetNear(boxes, BoxRay(glm::dvec3(ray.origin), glm::dvec3(ray.direction)),
                 [&](uint32_t tet) {
                   const RaySegment<Real> segment = CutTet(field.mesh, tet, ray);
                   if (segment.begin < segment.end) segments.push_back(segment);
                 });
  std::sort(segments.begin(), segments.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  Real depth(0);
  size_t count = 0;
  while (count < segments.size() && depth < stop_depth) {
    depth += EndsOf(field, segments[count]).depth();
    ++count;
  }
  segments.resize(count);
  return segments;
}

// The colour and depth of a ray.
template <class Real>
struct RayResult {
  Vec3<Real> color_srgb{Real(0)};  // before the background
  Real optical_depth{0};
  Real length{0};  // inside the mesh [world units]
  uint64_t tets = 0;
};

template <class Real>
RayResult<Real> IntegrateRay(const RadianceField& field, std::span<const RaySegment<Real>> segments,
                             const IntegralOptions& integral) {
  RayResult<Real> result;
  result.tets = segments.size();
  for (const RaySegment<Real>& segment : segments) {
    const SegmentEnds<Real> ends = EndsOf(field, segment);
    const SegmentWeights<Real> weights =
        IntegrateSegmentBy(int(integral.kind), integral.splits, ends.s0, ends.s1);
    result.color_srgb +=
        std::exp(-result.optical_depth) * (weights.w0 * ends.c0 + weights.w1 * ends.c1);
    result.optical_depth += ends.depth();
    result.length += segment.end - segment.begin;
  }
  return result;
}

// The distance along the ray at which its optical depth reaches `depth`; nothing if it never does.
template <class Real>
std::optional<Real> ReachOf(const RadianceField& field, std::span<const RaySegment<Real>> segments,
                            Real depth) {
  Real before(0);
  for (const RaySegment<Real>& segment : segments) {
    const SegmentEnds<Real> ends = EndsOf(field, segment);
    if (before + ends.depth() >= depth) {
      const Real share = ReachInSegment(ends.s0, ends.s1, depth - before);
      const Real begin = glm::mix(segment.begin, segment.end, ends.cut.begin);
      return begin + share * ends.length;
    }
    before += ends.depth();
  }
  return std::nullopt;
}

// The spatial gradient of a quantity that is linear in a tet, from its values at the vertices.
template <class Real>
Vec3<Real> GradientInTet(const TetMesh& mesh, uint32_t tet, const Vec4<Real>& values) {
  const glm::uvec4& ids = mesh.tets[tet];
  const Vec3<Real> origin(mesh.positions[ids[0]]);
  const Vec3<Real> a = Vec3<Real>(mesh.positions[ids[1]]) - origin,
                   b = Vec3<Real>(mesh.positions[ids[2]]) - origin,
                   c = Vec3<Real>(mesh.positions[ids[3]]) - origin;
  const Vec3<Real> sum = (values[1] - values[0]) * glm::cross(b, c) +
                         (values[2] - values[0]) * glm::cross(c, a) +
                         (values[3] - values[0]) * glm::cross(a, b);
  return sum / glm::dot(a, glm::cross(b, c));
}

// dL/d(distance, density, g . colour) of one end of a segment.
template <class Real>
struct EndGradient {
  Real by_distance, by_density, by_payload;

  EndGradient operator*(Real f) const { return {f * by_distance, f * by_density, f * by_payload}; }
  EndGradient operator+(const EndGradient& b) const {
    return {by_distance + b.by_distance, by_density + b.by_density, by_payload + b.by_payload};
  }
};

// The gradient that an end of a segment in `tet`, on `face`, contributes to a vertex of weight 1.
// If a vertex moves by m, the quantity q at a fixed point changes by -w grad(q).m, and the end
// slides along the ray d by w n.m / n.d, with n the face's normal. An end at the ray's origin does
// not slide.
template <class Real>
Vec3<Real> MoveGradient(const RadianceField& field, uint32_t tet, int face,
                        const Vec3<Real>& direction, const Vec3<Real>& g,
                        const EndGradient<Real>& end) {
  Vec4<Real> density(Real(0)), payload(Real(0));  // cells have no slope
  for (int i = 0; i < 4 && field.storage == FieldStorage::kVertex; ++i) {
    const uint32_t id = field.mesh.tets[tet][i];
    density[i] = Real(field.density[id]);
    payload[i] = glm::dot(g, Vec3<Real>(field.color_srgb[id]));
  }
  const Vec3<Real> slope = end.by_density * GradientInTet(field.mesh, tet, density) +
                           end.by_payload * GradientInTet(field.mesh, tet, payload);
  if (face == kNoFace) return -slope;
  const Vec3<Real> normal = PlaneOf<Real>(field.mesh, field.mesh.tets[tet], face).normal;
  const Real by_slide = end.by_distance + glm::dot(slope, direction);
  return by_slide / glm::dot(normal, direction) * normal - slope;
}

// The contribution of one passage of a ray through the tets around a vertex to that vertex. If
// cells have the attributes, it is that to the vertex's position alone, or that of a tet to its
// row.
template <class Real>
struct VertexGradient {
  uint32_t vertex;  // of the position
  uint32_t row;     // of colour and density
  Vec3<Real> color_srgb{Real(0)};
  Real density{0};
  Vec3<Real> position{Real(0)};
  Real absolute_position{0};  // as GradientSums::absolute_position
};

// The sums of one ray for the vertices of its current tet. A vertex that the ray leaves is added to
// the list.
template <class Real>
class Passages {
 public:
  // `has_rows`: vertices (not cells) have the attributes.
  Passages(const Vec3<Real>& direction, bool has_rows, std::vector<VertexGradient<Real>>& out)
      : direction_(direction), has_rows_(has_rows), out_(out) {}

  // Releases the vertices that do not belong to `tet`.
  void Enter(const glm::uvec4& tet) {
    std::array<VertexGradient<Real>, 4> now;
    for (int i = 0; i < 4; ++i) now[i].vertex = tet[i], now[i].row = has_rows_ ? tet[i] : 0;
    for (int k = 0; k < count_; ++k) {
      const auto same = std::find_if(now.begin(), now.end(), [&](const VertexGradient<Real>& v) {
        return v.vertex == held_[k].vertex;
      });
      if (same != now.end()) {
        *same = held_[k];
      } else {
        LetGo(held_[k]);
      }
    }
    held_ = now;
    count_ = 4;
  }
  VertexGradient<Real>& corner(int i) { return held_[i]; }
  void Leave() {
    for (int k = 0; k < count_; ++k) LetGo(held_[k]);
    count_ = 0;
  }

 private:
  void LetGo(const VertexGradient<Real>& passage) {
    const Vec3<Real>& move = passage.position;
    out_.push_back(passage);
    out_.back().absolute_position = glm::length(move - glm::dot(move, direction_) * direction_);
  }

  Vec3<Real> direction_;
  bool has_rows_;
  std::vector<VertexGradient<Real>>& out_;
  std::array<VertexGradient<Real>, 4> held_;
  int count_ = 0;
};

// Appends the gradients of a loss whose gradient by the ray's (rgb, transmittance) is
// `pixel_gradient`. A vertex occurs once per passage.
template <class Real>
void AppendRayGradient(const RadianceField& field, std::span<const RaySegment<Real>> segments,
                       const Vec3<Real>& direction, const Vec4<Real>& pixel_gradient,
                       const IntegralOptions& integral, bool with_positions,
                       std::vector<VertexGradient<Real>>& out) {
  const Vec3<Real> g(pixel_gradient);
  const bool cells = field.storage == FieldStorage::kCell;
  Passages<Real> passages(direction, !cells, out);
  std::vector<Real> depth_before;
  Real depth(0);
  for (const RaySegment<Real>& segment : segments) {
    depth_before.push_back(depth);
    depth += EndsOf(field, segment).depth();
  }
  // Back to front. `behind` is the part of the loss from behind the segment, per transmittance
  // there.
  Real behind = pixel_gradient.a;
  for (size_t i = segments.size(); i-- > 0;) {
    const RaySegment<Real>& segment = segments[i];
    const SegmentEnds<Real> ends = EndsOf(field, segment);
    const Real before = std::exp(-depth_before[i]), own = std::exp(-ends.depth());
    const SegmentAdjoint<Real> a =
        IntegrateSegmentByWithDerivatives(int(integral.kind), integral.splits, ends.s0, ends.s1);
    const Real k0 = glm::dot(g, ends.c0), k1 = glm::dot(g, ends.c1);
    const Real by_s0 = before * (a.dw0_ds0 * k0 + a.dw1_ds0 * k1 - Real(0.5) * own * behind);
    const Real by_s1 = before * (a.dw0_ds1 * k0 + a.dw1_ds1 * k1 - Real(0.5) * own * behind);
    const Real by_length =
        ends.length > 0 ? (ends.s0 * by_s0 + ends.s1 * by_s1) / ends.length : Real(0);
    const EndGradient<Real> at_begin{-by_length, ends.length * by_s0, before * a.w0};
    const EndGradient<Real> at_end{by_length, ends.length * by_s1, before * a.w1};
    const Real cut0 = ends.cut.begin, cut1 = ends.cut.end;
    const EndGradient<Real> begin = at_begin * (1 - cut0) + at_end * (1 - cut1);
    const EndGradient<Real> end = at_begin * cut0 + at_end * cut1;
    Vec3<Real> begin_move(Real(0)), end_move(Real(0));
    if (with_positions) {
      begin_move = MoveGradient<Real>(field, segment.tet, segment.begin_face, direction, g, begin);
      end_move = MoveGradient<Real>(field, segment.tet, segment.end_face, direction, g, end);
    }
    // Behind a gap, a vertex starts another passage.
    if (segment.end_face >= 0 && field.mesh.neighbors[segment.tet][segment.end_face] == kNoTet) {
      passages.Leave();
    }
    passages.Enter(field.mesh.tets[segment.tet]);
    for (int j = 0; j < 4; ++j) {
      const Real near = segment.begin_weights[j], far = segment.end_weights[j];
      VertexGradient<Real>& corner = passages.corner(j);
      if (!cells) {
        corner.color_srgb += (begin.by_payload * near + end.by_payload * far) * g;
        corner.density += begin.by_density * near + end.by_density * far;
      }
      corner.position += near * begin_move + far * end_move;
    }
    if (cells) {
      out.push_back({.vertex = field.mesh.tets[segment.tet][0],
                     .row = segment.tet,
                     .color_srgb = (begin.by_payload + end.by_payload) * g,
                     .density = begin.by_density + end.by_density});
    }
    behind = a.w0 * k0 + a.w1 * k1 + own * behind;
  }
  passages.Leave();
}

}  // namespace tetrec
