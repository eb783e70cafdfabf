// Integrates rays through volumes: the walk over cells, both shadings, images.
#include "volume/ray_integrator.h"

#include "core/error.h"
#include "core/parallel.h"
#include "scene/supersampling.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace tetrec {
namespace {

constexpr int kBlockCells = 4;

// a[0] + a[1] s + a[2] s^2 + a[3] s^3
template <class T>
struct Cubic {
  T a[4];

  T At(float s) const { return a[0] + s * (a[1] + s * (a[2] + s * a[3])); }
};

// The trilinear interpolant of a cell's corners along entry + s * step, in the cell's own [0, 1]^3.
// In the order of corners x is fastest.
template <class T>
Cubic<T> AlongRay(const std::array<T, 8>& corner, const glm::vec3& entry, const glm::vec3& step) {
  const T x = corner[1] - corner[0], y = corner[2] - corner[0], z = corner[4] - corner[0];
  const T xy = corner[3] - corner[2] - x, xz = corner[5] - corner[4] - x;
  const T yz = corner[6] - corner[4] - y;
  const T xyz = corner[7] - corner[6] - corner[5] + corner[4] - xy;
  // First and mixed derivatives of the interpolant at the entry.
  const T at_x = x + entry.y * xy + entry.z * xz + (entry.y * entry.z) * xyz;
  const T at_y = y + entry.x * xy + entry.z * yz + (entry.x * entry.z) * xyz;
  const T at_z = z + entry.x * xz + entry.y * yz + (entry.x * entry.y) * xyz;
  const T at_xy = xy + entry.z * xyz, at_xz = xz + entry.y * xyz, at_yz = yz + entry.x * xyz;
  Cubic<T> cubic;
  cubic.a[0] = corner[0] + entry.x * x + entry.y * (y + entry.x * xy) + entry.z * at_z;
  cubic.a[1] = step.x * at_x + step.y * at_y + step.z * at_z;
  cubic.a[2] = (step.x * step.y) * at_xy + (step.x * step.z) * at_xz + (step.y * step.z) * at_yz;
  cubic.a[3] = (step.x * step.y * step.z) * xyz;
  return cubic;
}

// The s in [begin, end] at which the cubic, which is monotone there, has the value, found by regula
// falsi with the Illinois modification and by bisection where that leaves the interval.
float FindCrossing(const Cubic<float>& cubic, float begin, float end, float value) {
  float at_begin = cubic.At(begin) - value, at_end = cubic.At(end) - value;
  for (int i = 0; i < 30 && end - begin > 1e-6f; ++i) {
    const float slope = at_end - at_begin;
    float s = slope != 0 ? begin - at_begin * (end - begin) / slope : begin;
    if (!(s > begin && s < end)) s = 0.5f * (begin + end);
    const float at_s = cubic.At(s) - value;
    if (at_s == 0) return s;
    if ((at_s < 0) == (at_end < 0)) {
      end = s;
      at_end = at_s;
      at_begin *= 0.5f;
    } else {
      begin = s;
      at_begin = at_s;
      at_end *= 0.5f;
    }
  }
  return 0.5f * (begin + end);
}

// The extrema of the cubic within (0, 1): 0, 1 or 2, in rising order.
int FindTurns(const Cubic<float>& cubic, std::array<float, 2>& turns) {
  const float a = 3 * cubic.a[3], b = cubic.a[2], c = cubic.a[1];  // a s^2 + 2 b s + c
  const float inside = b * b - a * c;
  if (!(inside > 0)) return 0;
  const float q = -(b + std::copysign(std::sqrt(inside), b));
  std::array<float, 2> roots = {a != 0 ? q / a : -1.0f, q != 0 ? c / q : -1.0f};
  std::sort(roots.begin(), roots.end());
  int count = 0;
  for (const float root : roots) {
    if (root > 0 && root < 1) turns[size_t(count++)] = root;
  }
  return count;
}

}  // namespace

// A ray's way through one cell.
struct RayIntegrator::CellPassage {
  size_t sample;          // index of the cell's first corner
  glm::vec3 entry, step;  // in the cell's [0, 1]^3: entry point, and from there to the exit
  float length_in_world;
};

// Colour and optical depth gathered along a ray so far.
struct RayIntegrator::Gathering {
  int parts;
  glm::vec3 color{0.0f};
  float depth = 0, transmittance = 1;

  bool Continues() const { return transmittance > kStopTransmittance; }

  // Adds the part [begin, end] of a cell, in which optical depth grows by `rate` per unit of s.
  template <class ColorAt>
  void Add(const Cubic<float>& rate, float begin, float end, const ColorAt& color_at) {
    constexpr float kNode[] = {0.069431844f, 0.33000948f, 0.66999052f, 0.93056816f};
    constexpr float kWeight[] = {0.17392742f, 0.32607258f, 0.32607258f, 0.17392742f};
    constexpr float kMostParts = 1e6f;  // the ray stops after some tens of them
    const auto depth_at = [&](float s) {
      return s * (rate.a[0] + s * (rate.a[1] / 2 + s * (rate.a[2] / 3 + s * (rate.a[3] / 4))));
    };
    const float depth_of_all = depth_at(end) - depth_at(begin);
    if (!(depth_of_all > 0)) return;
    const int count = parts * int(std::ceil(std::min(depth_of_all, kMostParts)));
    const float size = (end - begin) / float(count);
    for (int i = 0; i < count && Continues(); ++i) {
      const float from = begin + float(i) * size;
      const float depth_before = depth_at(from);
      for (int k = 0; k < 4; ++k) {
        const float s = from + kNode[k] * size;
        const float weight = kWeight[k] * size * rate.At(s) * std::exp(depth_before - depth_at(s));
        color += (transmittance * weight) * color_at(s);
      }
      depth += depth_at(from + size) - depth_before;
      transmittance = std::exp(-depth);
    }
  }
};

RayIntegrator::RayIntegrator(const Volume& volume, const TransferFunction& function,
                             double density_at_opacity_1, Shading shading,
                             const Similarity3& world_from_volume)
    : volume_(volume),
      transfer_(function),
      density_at_opacity_1_(float(density_at_opacity_1)),
      shading_(shading),
      origin_in_world_(world_from_volume * volume.origin),
      spacing_in_world_(world_from_volume.scale * volume.spacing) {
  TETREC_CHECK(world_from_volume.rotation == glm::dmat3(1.0), "a rotated volume");
  ShadeSamples(function);
  FindVisibleBlocks();
}

void RayIntegrator::ShadeSamples(const TransferFunction& function) {
  shaded_.resize(volume_.samples.size());
  std::atomic<size_t> dense = 0;
  ParallelFor(shaded_.size(), size_t{1} << 16, [&](size_t begin, size_t end) {
    size_t dense_here = 0;
    for (size_t i = begin; i < end; ++i) {
      const float sample = volume_.samples[i];
      const float opacity = float(function.OpacityAt(sample));
      const glm::vec3 color = transfer_.SrgbAt(transfer_.PieceOf(sample), sample);
      shaded_[i] = glm::vec4(density_at_opacity_1_ * opacity, color);
      dense_here += shaded_[i].x > 0;
    }
    dense += dense_here;
  });
  dense_ = dense;
}

bool RayIntegrator::AnythingVisible() const {
  return std::find(visible_block_.begin(), visible_block_.end(), 1) != visible_block_.end();
}

bool RayIntegrator::IsVisible(const glm::ivec3& block) const {
  const glm::ivec3 first = block * kBlockCells;
  const glm::ivec3 last = glm::min(first + kBlockCells, volume_.size - 1);
  float least = 1, most = 0;
  bool dense = false;
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const size_t i =
            (size_t(z) * size_t(volume_.size.y) + size_t(y)) * size_t(volume_.size.x) + size_t(x);
        least = std::min(least, volume_.samples[i]);
        most = std::max(most, volume_.samples[i]);
        dense = dense || shaded_[i].x > 0;
      }
    }
  }
  if (dense || shading_ == Shading::kPre || !(least < most)) return dense;
  // Values strictly between the two extremes: the last piece counts only beyond its lower end.
  int last_piece = transfer_.PieceOf(most);
  if (transfer_.Knot(last_piece) == most) --last_piece;
  return transfer_.IsVisible(transfer_.PieceOf(least), last_piece);
}

void RayIntegrator::FindVisibleBlocks() {
  blocks_ = (volume_.size - 1 + kBlockCells - 1) / kBlockCells;
  const size_t row = size_t(blocks_.x), layer = row * size_t(blocks_.y);
  visible_block_.resize(layer * size_t(blocks_.z));
  ParallelFor(visible_block_.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      visible_block_[i] =
          IsVisible({int(i % row), int(i / row % size_t(blocks_.y)), int(i / layer)});
    }
  });
}

// Calls visit(passage) for every cell of a visible block along the ray, in order, until it returns
// false. Origin and direction are in units of cells relative to the first sample; the ray parameter
// is in world units.
template <class Visit>
void RayIntegrator::Walk(const glm::dvec3& origin, const glm::dvec3& direction,
                         const Visit& visit) const {
  const glm::dvec3 inverse = 1.0 / direction;  // infinite for a component of 0
  const glm::ivec3 cells = volume_.size - 1;
  double t = 0, t_end = INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin[axis] < 0 || origin[axis] > cells[axis]) return;
      continue;
    }
    const double a = -origin[axis] * inverse[axis];
    const double b = (cells[axis] - origin[axis]) * inverse[axis];
    t = std::max(t, std::min(a, b));
    t_end = std::min(t_end, std::max(a, b));
  }
  glm::ivec3 cell =
      glm::clamp(glm::ivec3(glm::floor(origin + t * direction)), glm::ivec3(0), cells - 1);
  const auto exit_of = [&](int axis, int lower, int upper) {
    if (direction[axis] == 0) return double(INFINITY);
    return ((direction[axis] > 0 ? upper : lower) - origin[axis]) * inverse[axis];
  };
  while (t < t_end) {
    const glm::ivec3 block = cell / kBlockCells;
    const bool visible =
        visible_block_[(size_t(block.z) * size_t(blocks_.y) + size_t(block.y)) * size_t(blocks_.x) +
                       size_t(block.x)] != 0;
    // The box to pass through: the cell, or the whole block if it is empty.
    const glm::ivec3 lower = visible ? cell : block * kBlockCells;
    const glm::ivec3 upper = lower + (visible ? 1 : kBlockCells);
    int axis = 0;
    double t_out = INFINITY;
    for (int i = 0; i < 3; ++i) {
      const double exit = exit_of(i, lower[i], upper[i]);
      if (exit < t_out) {
        t_out = exit;
        axis = i;
      }
    }
    t_out = std::min(t_out, t_end);
    if (visible && t_out > t) {
      const glm::dvec3 entry = origin + t * direction - glm::dvec3(cell);
      CellPassage passage;
      passage.sample =
          (size_t(cell.z) * size_t(volume_.size.y) + size_t(cell.y)) * size_t(volume_.size.x) +
          size_t(cell.x);
      passage.entry = glm::vec3(entry);
      passage.step = glm::vec3((t_out - t) * direction);
      passage.length_in_world = float(t_out - t);
      if (!visit(passage)) return;
    }
    t = std::max(t, t_out);
    // Step into the neighbour. Passing a whole block may have changed the cell along the other
    // axes.
    if (!visible) {
      const glm::ivec3 inside = glm::min(upper, cells) - 1;
      cell = glm::clamp(glm::ivec3(glm::floor(origin + t * direction)), lower, inside);
    }
    cell[axis] = direction[axis] > 0 ? upper[axis] : lower[axis] - 1;
    if (cell[axis] < 0 || cell[axis] >= cells[axis]) return;
  }
}

// The corners of a cell of an array of samples, x fastest.
template <class T>
std::array<T, 8> CornersOf(const std::vector<T>& samples, size_t first, const glm::ivec3& size) {
  const T* low = samples.data() + first;
  const size_t row = size_t(size.x), layer = row * size_t(size.y);
  const T* high = low + layer;
  return {low[0], low[1], low[row], low[row + 1], high[0], high[1], high[row], high[row + 1]};
}

bool RayIntegrator::GatherPreShaded(const CellPassage& passage, Gathering& gathering) const {
  const std::array<glm::vec4, 8> corner = CornersOf(shaded_, passage.sample, volume_.size);
  float densest = 0;
  for (const glm::vec4& c : corner) densest = std::max(densest, c.x);
  if (densest == 0) return true;
  const Cubic<glm::vec4> cubic = AlongRay(corner, passage.entry, passage.step);
  Cubic<float> rate;
  for (int i = 0; i < 4; ++i) rate.a[i] = passage.length_in_world * cubic.a[i].x;
  gathering.Add(rate, 0, 1, [&](float s) {
    const glm::vec4 value = cubic.At(s);
    return glm::vec3(value.y, value.z, value.w);
  });
  return gathering.Continues();
}

bool RayIntegrator::GatherPostShaded(const CellPassage& passage, Gathering& gathering) const {
  const std::array<float, 8> corner = CornersOf(volume_.samples, passage.sample, volume_.size);
  const auto extremes = std::minmax_element(corner.begin(), corner.end());
  const auto least = *extremes.first, most = *extremes.second;
  const int first_piece = transfer_.PieceOf(least), last_piece = transfer_.PieceOf(most);
  if (!transfer_.IsVisible(first_piece, last_piece)) return true;
  const Cubic<float> sample = AlongRay(corner, passage.entry, passage.step);

  const auto add = [&](int piece, float begin, float end) {
    if (!transfer_.IsVisible(piece, piece)) return;
    const float scale = density_at_opacity_1_ * passage.length_in_world;
    const float slope = scale * transfer_.OpacitySlope(piece);
    Cubic<float> rate;
    for (int i = 0; i < 4; ++i) rate.a[i] = slope * sample.a[i];
    rate.a[0] += scale * transfer_.OpacityOffset(piece);
    gathering.Add(rate, begin, end, [&](float s) { return transfer_.SrgbAt(piece, sample.At(s)); });
  };
  if (first_piece == last_piece) {
    add(first_piece, 0, 1);
    return gathering.Continues();
  }
  // Between its extrema the sample is monotone and crosses knots in order.
  std::array<float, 2> turns{};
  const int turn_count = FindTurns(sample, turns);
  float begin = 0;
  for (int i = 0; i <= turn_count && gathering.Continues(); ++i) {
    const float end = i < turn_count ? turns[size_t(i)] : 1;
    const auto piece_at = [&](float s) {
      return transfer_.PieceOf(glm::clamp(sample.At(s), least, most));
    };
    int piece = piece_at(begin);
    const int last = piece_at(end);
    const int direction = last > piece ? 1 : -1;
    while (piece != last) {
      const float knot = transfer_.Knot(direction > 0 ? piece + 1 : piece);
      const float crossing = FindCrossing(sample, begin, end, knot);
      add(piece, begin, crossing);
      begin = crossing;
      piece += direction;
    }
    add(piece, begin, end);
    begin = end;
  }
  return gathering.Continues();
}

GatheredColor RayIntegrator::Gather(const glm::dvec3& origin_in_world,
                                    const glm::dvec3& unit_direction_in_world, int parts) const {
  Gathering gathering{parts};
  const glm::dvec3 origin = (origin_in_world - origin_in_world_) / spacing_in_world_;
  const glm::dvec3 direction = unit_direction_in_world / spacing_in_world_;
  if (shading_ == Shading::kPre) {
    Walk(origin, direction, [&](const CellPassage& p) { return GatherPreShaded(p, gathering); });
  } else {
    Walk(origin, direction, [&](const CellPassage& p) { return GatherPostShaded(p, gathering); });
  }
  return {gathering.color, -std::expm1(-gathering.depth)};
}

Image RenderVolume(const RayIntegrator& rays, const Camera& camera, const Rigid3& cam_from_world,
                   int rays_per_side) {
  return RenderSupersampled(camera, cam_from_world, rays_per_side, /*has_alpha=*/true,
                            [&](const glm::dvec3& origin, const glm::dvec3& direction) {
                              return rays.Gather(origin, direction);
                            });
}

}  // namespace tetrec
