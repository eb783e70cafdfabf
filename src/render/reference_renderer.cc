// The renderer that judges the others: double precision on the CPU.
#include "render/reference_renderer.h"

#include "core/error.h"
#include "core/parallel.h"
#include "shared/integral.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

using glm::dvec3;
using glm::dvec4;

struct Ray {
  dvec3 origin, direction;  // world, direction of length 1
};

constexpr int kNoFace = -1;

// The part of a ray inside one tet, with the barycentric weights of its ends.
struct Segment {
  double begin, end;  // along the ray [world units]
  uint32_t tet;
  dvec4 begin_weights, end_weights;
  int begin_face = kNoFace, end_face = kNoFace;  // kNoFace: at the ray's origin
};

struct Sphere {
  dvec3 center;
  double radius;
};

std::vector<Sphere> BoundingSpheres(const TetMesh& mesh) {
  std::vector<Sphere> spheres;
  for (const glm::uvec4& tet : mesh.tets) {
    Sphere sphere{dvec3(0.0), 0.0};
    for (int i = 0; i < 4; ++i) sphere.center += 0.25 * dvec3(mesh.positions[tet[i]]);
    for (int i = 0; i < 4; ++i) {
      sphere.radius =
          std::max(sphere.radius, glm::distance(sphere.center, dvec3(mesh.positions[tet[i]])));
    }
    spheres.push_back(sphere);
  }
  return spheres;
}

Ray PixelRay(const RenderView& view, int x, int y) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const dvec3 in_cam = view.camera.CamFromImage({x + 0.5, y + 0.5});
  return {world_from_cam.translation, glm::normalize(world_from_cam.rotation * in_cam)};
}

bool Touches(const Ray& ray, const Sphere& sphere) {
  const dvec3 to_center = sphere.center - ray.origin;
  const double along = glm::dot(to_center, ray.direction);
  const double radius = sphere.radius * (1.0 + 1e-9);
  return along > -radius &&
         glm::dot(to_center, to_center) - along * along <= radius * radius * (1.0 + 1e-9);
}

// The plane through three vertices, computed in the order of their ids: the two tets at a face get
// the same rounding, so their segments join without gap or overlap.
struct Plane {
  dvec3 normal, point;
};

Plane FacePlane(const TetMesh& mesh, const glm::uvec4& tet, int face) {
  std::array<uint32_t, 3> ids;
  for (int i = 0; i < 3; ++i) ids[i] = tet[(face + 1 + i) % 4];
  std::sort(ids.begin(), ids.end());
  const dvec3 a(mesh.positions[ids[0]]), b(mesh.positions[ids[1]]), c(mesh.positions[ids[2]]);
  return {glm::cross(b - a, c - a), a};
}

// Cuts the ray's part ahead of its origin with the four planes; empty where begin >= end.
Segment CutTet(const TetMesh& mesh, uint32_t t, const Ray& ray) {
  const glm::uvec4& tet = mesh.tets[t];
  Segment segment{0.0, std::numeric_limits<double>::infinity(), t, {}, {}};
  dvec4 weight_at_origin(0.0), weight_slope(0.0);
  for (int i = 0; i < 4; ++i) {
    const Plane plane = FacePlane(mesh, tet, i);
    const double at_vertex = glm::dot(plane.normal, dvec3(mesh.positions[tet[i]]) - plane.point);
    const double at_origin = glm::dot(plane.normal, ray.origin - plane.point);
    const double slope = glm::dot(plane.normal, ray.direction);
    weight_at_origin[i] = at_origin / at_vertex;
    weight_slope[i] = slope / at_vertex;
    if (weight_slope[i] > 0.0) {
      if (-at_origin / slope > segment.begin) {
        segment.begin = -at_origin / slope;
        segment.begin_face = i;
      }
    } else if (weight_slope[i] < 0.0) {
      if (-at_origin / slope < segment.end) {
        segment.end = -at_origin / slope;
        segment.end_face = i;
      }
    } else {
      // Parallel. A ray inside the face's plane belongs to the side that a fixed direction points
      // to.
      const double side = glm::dot(plane.normal, dvec3(0.51, 0.62, 0.59)) / at_vertex;
      const bool outside = weight_at_origin[i] < 0.0 || (weight_at_origin[i] == 0.0 && side < 0.0);
      if (outside) segment.end = -1.0;
    }
  }
  segment.begin_weights = weight_at_origin + segment.begin * weight_slope;
  segment.end_weights = weight_at_origin + segment.end * weight_slope;
  return segment;
}

double InterpolateDensity(const RadianceField& field, uint32_t tet, const dvec4& weights) {
  if (field.storage == FieldStorage::kCell) return field.density[tet];
  double density = 0.0;
  for (int i = 0; i < 4; ++i) density += weights[i] * field.density[field.mesh.tets[tet][i]];
  return std::max(density, 0.0);
}

dvec3 InterpolateColor(const RadianceField& field, uint32_t tet, const dvec4& weights) {
  if (field.storage == FieldStorage::kCell) return dvec3(field.color_srgb[tet]);
  dvec3 color(0.0);
  for (int i = 0; i < 4; ++i) {
    color += weights[i] * dvec3(field.color_srgb[field.mesh.tets[tet][i]]);
  }
  return color;
}

// s0 and s1 of segment.glsl.h, and the colours at the ends.
struct Ends {
  double s0, s1;
  dvec3 c0, c1;
};

Ends EndsOf(const RadianceField& field, const Segment& segment) {
  const double length = segment.end - segment.begin;
  return {length * InterpolateDensity(field, segment.tet, segment.begin_weights),
          length * InterpolateDensity(field, segment.tet, segment.end_weights),
          InterpolateColor(field, segment.tet, segment.begin_weights),
          InterpolateColor(field, segment.tet, segment.end_weights)};
}

// Front to back, up to and with the tet in which the optical depth reaches `stop_depth`.
std::vector<Segment> CutMesh(const RadianceField& field, std::span<const Sphere> spheres,
                             const Ray& ray, double stop_depth) {
  std::vector<Segment> segments;
  for (uint32_t t = 0; t < spheres.size(); ++t) {
    if (!Touches(ray, spheres[t])) continue;
    const Segment segment = CutTet(field.mesh, t, ray);
    if (segment.begin < segment.end) segments.push_back(segment);
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.begin < b.begin; });
  double depth = 0.0;
  size_t count = 0;
  while (count < segments.size() && depth < stop_depth) {
    const Ends ends = EndsOf(field, segments[count]);
    depth += 0.5 * (ends.s0 + ends.s1);
    ++count;
  }
  segments.resize(count);
  return segments;
}

// Gradient in space of a quantity that is linear in a tet, from its values at the vertices.
dvec3 GradientInTet(const TetMesh& mesh, uint32_t tet, const dvec4& values) {
  const glm::uvec4& ids = mesh.tets[tet];
  const dvec3 origin(mesh.positions[ids[0]]);
  const dvec3 a = dvec3(mesh.positions[ids[1]]) - origin,
              b = dvec3(mesh.positions[ids[2]]) - origin,
              c = dvec3(mesh.positions[ids[3]]) - origin;
  const dvec3 sum = (values[1] - values[0]) * glm::cross(b, c) +
                    (values[2] - values[0]) * glm::cross(c, a) +
                    (values[3] - values[0]) * glm::cross(a, b);
  return sum / glm::dot(a, glm::cross(b, c));
}

// dL/d(distance, density, g . colour) of one end of a segment.
struct EndGradient {
  double by_distance, by_density, by_payload;
};

// What an end of a segment in `tet`, on `face`, gives to a vertex of weight 1. A vertex that moves
// by m takes the quantity q at a fixed place along by -w grad(q).m; the end slides along the ray d
// by w n.m / n.d, n the face's normal. An end at the ray's origin does not slide.
dvec3 MoveGradient(const RadianceField& field, uint32_t tet, int face, const dvec3& direction,
                   const dvec3& g, const EndGradient& end) {
  dvec4 density(0.0), payload(0.0);  // cells have no slope
  for (int i = 0; i < 4 && field.storage == FieldStorage::kVertex; ++i) {
    const uint32_t id = field.mesh.tets[tet][i];
    density[i] = field.density[id];
    payload[i] = glm::dot(g, dvec3(field.color_srgb[id]));
  }
  const dvec3 slope = end.by_density * GradientInTet(field.mesh, tet, density) +
                      end.by_payload * GradientInTet(field.mesh, tet, payload);
  if (face == kNoFace) return -slope;
  const dvec3 normal = FacePlane(field.mesh, field.mesh.tets[tet], face).normal;
  const double by_slide = end.by_distance + glm::dot(slope, direction);
  return by_slide / glm::dot(normal, direction) * normal - slope;
}

// Sums of the position gradients of one ray, for the vertices of the tet that it is in.
class Passages {
 public:
  Passages(const dvec3& direction, ReferenceGradient& gradient)
      : direction_(direction), gradient_(gradient) {}

  // Lets the vertices go that `tet` lacks.
  void Enter(const glm::uvec4& tet) {
    std::array<Passage, 4> now;
    for (int i = 0; i < 4; ++i) now[i] = {tet[i], dvec3(0.0)};
    for (const Passage& before : held_) {
      const auto same =
          std::find_if(now.begin(), now.end(), [&](const Passage& p) { return p.id == before.id; });
      if (same != now.end()) {
        same->sum = before.sum;
      } else {
        LetGo(before);
      }
    }
    held_.assign(now.begin(), now.end());
  }
  void Add(int corner, const dvec3& value) { held_[corner].sum += value; }
  void Leave() {
    for (const Passage& passage : held_) LetGo(passage);
    held_.clear();
  }

 private:
  struct Passage {
    uint32_t id;
    dvec3 sum;
  };

  void LetGo(const Passage& passage) {
    gradient_.position[passage.id] += passage.sum;
    const dvec3 across = passage.sum - glm::dot(passage.sum, direction_) * direction_;
    gradient_.absolute_position[passage.id] += glm::length(across);
  }

  dvec3 direction_;
  ReferenceGradient& gradient_;
  std::vector<Passage> held_;
};

void AddRayGradient(const RadianceField& field, std::span<const Segment> segments,
                    const dvec3& direction, const dvec4& pixel_gradient,
                    const IntegralOptions& integral, ReferenceGradient& gradient) {
  const dvec3 g(pixel_gradient);
  Passages passages(direction, gradient);
  std::vector<double> depth_before;
  double depth = 0.0;
  for (const Segment& segment : segments) {
    const Ends ends = EndsOf(field, segment);
    depth_before.push_back(depth);
    depth += 0.5 * (ends.s0 + ends.s1);
  }
  // Back to front: `behind` is the loss's part from behind the segment, per transmittance there.
  double behind = pixel_gradient.a;
  for (size_t i = segments.size(); i-- > 0;) {
    const Segment& segment = segments[i];
    const Ends ends = EndsOf(field, segment);
    const double before = std::exp(-depth_before[i]), own = std::exp(-0.5 * (ends.s0 + ends.s1));
    const double length = segment.end - segment.begin;
    const SegmentAdjoint<double> a =
        IntegrateSegmentByWithDerivatives(int(integral.kind), integral.splits, ends.s0, ends.s1);
    const double k0 = glm::dot(g, ends.c0), k1 = glm::dot(g, ends.c1);
    const double by_s0 = before * (a.dw0_ds0 * k0 + a.dw1_ds0 * k1 - 0.5 * own * behind);
    const double by_s1 = before * (a.dw0_ds1 * k0 + a.dw1_ds1 * k1 - 0.5 * own * behind);
    const double by_length = (ends.s0 * by_s0 + ends.s1 * by_s1) / length;
    const dvec3 begin_move = MoveGradient(field, segment.tet, segment.begin_face, direction, g,
                                          {-by_length, length * by_s0, before * a.w0});
    const dvec3 end_move = MoveGradient(field, segment.tet, segment.end_face, direction, g,
                                        {by_length, length * by_s1, before * a.w1});
    // Behind a gap a vertex begins another passage.
    if (field.mesh.neighbors[segment.tet][segment.end_face] == kNoTet) passages.Leave();
    passages.Enter(field.mesh.tets[segment.tet]);
    for (int j = 0; j < 4; ++j) {
      const uint32_t id = field.mesh.tets[segment.tet][j];
      const double near = segment.begin_weights[j], far = segment.end_weights[j];
      // The weights of the corners sum to 1: a cell gets the whole.
      const size_t row = field.storage == FieldStorage::kCell ? segment.tet : id;
      gradient.color_srgb[row] += before * (a.w0 * near + a.w1 * far) * g;
      gradient.density[row] += length * (by_s0 * near + by_s1 * far);
      passages.Add(j, near * begin_move + far * end_move);
    }
    behind = a.w0 * k0 + a.w1 * k1 + own * behind;
  }
  passages.Leave();
}

double StopDepth(double stop_transmittance) {
  return stop_transmittance > 0.0 ? -std::log(stop_transmittance)
                                  : std::numeric_limits<double>::infinity();
}

}  // namespace

ReferenceImage RenderReference(const RadianceField& field, const RenderView& view,
                               double stop_transmittance, const IntegralOptions& integral) {
  const std::vector<Sphere> spheres = BoundingSpheres(field.mesh);
  const int width = view.camera.width, height = view.camera.height;
  const size_t pixels = size_t(width) * size_t(height);
  ReferenceImage image{width, height, std::vector<dvec3>(pixels), std::vector<double>(pixels),
                       std::vector<double>(pixels)};
  ParallelFor(pixels, 64, [&](size_t first, size_t last) {
    for (size_t pixel = first; pixel < last; ++pixel) {
      const Ray ray = PixelRay(view, int(pixel % width), int(pixel / width));
      dvec3 color(0.0);
      double depth = 0.0, length = 0.0;
      for (const Segment& segment : CutMesh(field, spheres, ray, StopDepth(stop_transmittance))) {
        const Ends ends = EndsOf(field, segment);
        const SegmentWeights<double> weights =
            IntegrateSegmentBy(int(integral.kind), integral.splits, ends.s0, ends.s1);
        color += std::exp(-depth) * (weights.w0 * ends.c0 + weights.w1 * ends.c1);
        depth += 0.5 * (ends.s0 + ends.s1);
        length += segment.end - segment.begin;
      }
      image.color_srgb[pixel] = color;
      image.optical_depth[pixel] = depth;
      image.length[pixel] = length;
    }
  });
  return image;
}

ReferenceGradient BackpropagateReference(const RadianceField& field, const RenderView& view,
                                         std::span<const glm::dvec4> pixel_gradient,
                                         double stop_transmittance,
                                         const IntegralOptions& integral) {
  const std::vector<Sphere> spheres = BoundingSpheres(field.mesh);
  const int width = view.camera.width, height = view.camera.height;
  const size_t pixels = size_t(width) * size_t(height), vertices = field.mesh.positions.size();
  TETREC_CHECK(pixel_gradient.size() == pixels, fmt::format("{} gradients", pixel_gradient.size()));
  // A fixed number of partial sums: the result does not depend on the number of threads.
  constexpr size_t kParts = 8;
  std::vector<ReferenceGradient> parts(kParts, ReferenceGradient(field));
  ParallelFor(kParts, 1, [&](size_t first, size_t last) {
    for (size_t part = first; part < last; ++part) {
      for (size_t pixel = part; pixel < pixels; pixel += kParts) {
        const Ray ray = PixelRay(view, int(pixel % width), int(pixel / width));
        AddRayGradient(field, CutMesh(field, spheres, ray, StopDepth(stop_transmittance)),
                       ray.direction, pixel_gradient[pixel], integral, parts[part]);
      }
    }
  });
  for (size_t part = 1; part < kParts; ++part) {
    for (size_t row = 0; row < field.density.size(); ++row) {
      parts[0].color_srgb[row] += parts[part].color_srgb[row];
      parts[0].density[row] += parts[part].density[row];
    }
    for (size_t v = 0; v < vertices; ++v) {
      parts[0].position[v] += parts[part].position[v];
      parts[0].absolute_position[v] += parts[part].absolute_position[v];
    }
  }
  return parts[0];
}

}  // namespace tetrec
