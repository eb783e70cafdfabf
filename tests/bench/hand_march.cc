// The march of shaders/march.glsl and march_forward.comp in AVX2. Rows of the mesh are loaded whole
// and transposed in registers, state stays in registers, and thick segments, which are rare, are
// integrated lane by lane.
#include "hand_march.h"

#include "core/parallel.h"
#include "shared/segment.glsl.h"

#include <immintrin.h>

#include <cmath>

namespace tetrec {
namespace {

using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));

constexpr int kLanes = 8;

// A scalar of the shared formulas.
struct F8 {
  Floats v;
  F8() = default;
  F8(Floats lanes) : v(lanes) {}
  explicit F8(double value) : v(Floats{} + float(value)) {}
};
inline F8 operator+(F8 a, F8 b) { return a.v + b.v; }
inline F8 operator-(F8 a, F8 b) { return a.v - b.v; }
inline F8 operator-(F8 a) { return -a.v; }
inline F8 operator*(F8 a, F8 b) { return a.v * b.v; }

Ints Load(const int32_t* lanes) {
  return Ints(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(lanes)));
}
bool Any(Ints mask) { return _mm256_movemask_ps(_mm256_castsi256_ps(__m256i(mask))) != 0; }
Floats Max(Floats a, Floats b) { return Floats(_mm256_max_ps(__m256(a), __m256(b))); }
Floats Min(Floats a, Floats b) { return Floats(_mm256_min_ps(__m256(a), __m256(b))); }
Floats Abs(Floats a) { return Max(a, -a); }

// x = n ln 2 + r, |r| <= 0.35: the Taylor series of e^r up to r^7 has an error of 6e-9.
Floats Exp(Floats x) {
  x = Max(x, Floats{} - 87.0f);
  const Floats n = Floats(_mm256_round_ps(__m256(x * 1.44269504f), _MM_FROUND_TO_NEAREST_INT));
  const Floats r = (x - n * 0.693145752f) - n * 1.42860677e-6f;
  Floats sum = r * (1.0f / 5040) + 1.0f / 720;
  sum = sum * r + 1.0f / 120;
  sum = sum * r + 1.0f / 24;
  sum = sum * r + 1.0f / 6;
  sum = sum * r + 0.5f;
  sum = sum * r + 1.0f;
  sum = sum * r + 1.0f;
  const Ints power = (__builtin_convertvector(n, Ints) + 127) << 23;
  return sum * Floats(power);
}
inline F8 exp(F8 x) { return Exp(x.v); }

// Loads row `index` of every lane, 8 words each; out[word] is that word of all lanes.
void FetchRows(const float* rows, Ints index, Floats out[8]) {
  __m256 r[8], t[8];
  for (int i = 0; i < 8; ++i) r[i] = _mm256_loadu_ps(rows + 8 * size_t(uint32_t(index[i])));
  for (int i = 0; i < 8; i += 2) {
    t[i] = _mm256_unpacklo_ps(r[i], r[i + 1]);
    t[i + 1] = _mm256_unpackhi_ps(r[i], r[i + 1]);
  }
  for (int i = 0; i < 8; i += 4) {
    r[i] = _mm256_shuffle_ps(t[i], t[i + 2], 0x44);
    r[i + 1] = _mm256_shuffle_ps(t[i], t[i + 2], 0xEE);
    r[i + 2] = _mm256_shuffle_ps(t[i + 1], t[i + 3], 0x44);
    r[i + 3] = _mm256_shuffle_ps(t[i + 1], t[i + 3], 0xEE);
  }
  for (int i = 0; i < 4; ++i) {
    out[i] = Floats(_mm256_permute2f128_ps(r[i], r[i + 4], 0x20));
    out[i + 4] = Floats(_mm256_permute2f128_ps(r[i], r[i + 4], 0x31));
  }
}

struct Rays {
  Floats origin[3], u[3], v[3], direction[3];
};

struct Corner {
  Floats x, y, z;  // in the rays' own frames
  Floats density, color[3];
  Ints id;
};

Floats Dot(const Floats a[3], const Floats b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Floats EdgeFunction(const Corner& from, const Corner& to) { return from.x * to.y - from.y * to.x; }

void Replace(Corner& corner, Ints where, const Corner& fresh) {
  corner.x = where ? fresh.x : corner.x;
  corner.y = where ? fresh.y : corner.y;
  corner.z = where ? fresh.z : corner.z;
  corner.density = where ? fresh.density : corner.density;
  for (int i = 0; i < 3; ++i) corner.color[i] = where ? fresh.color[i] : corner.color[i];
  corner.id = where ? fresh.id : corner.id;
}

// The same rays as in rays.glsl.
Rays MakeRays(const RenderView& view, const Rigid3& world_from_cam, const RayBlock& block) {
  Rays rays;
  for (int lane = 0; lane < kLanes; ++lane) {
    const glm::dvec2 pixel(block.x + uint32_t(lane % kRayBlockWidth) + 0.5,
                           block.y + uint32_t(lane / kRayBlockWidth) + 0.5);
    const glm::vec3 d(glm::normalize(world_from_cam.rotation * view.camera.CamFromImage(pixel)));
    const float s = d.z >= 0.0f ? 1.0f : -1.0f, h = -1.0f / (s + d.z), k = d.x * d.y * h;
    const glm::vec3 u(1.0f + s * d.x * d.x * h, s * k, -s * d.x), v(k, s + d.y * d.y * h, -d.y);
    for (int i = 0; i < 3; ++i) {
      rays.origin[i][lane] = float(world_from_cam.translation[i]);
      rays.direction[i][lane] = d[i];
      rays.u[i][lane] = u[i];
      rays.v[i][lane] = v[i];
    }
  }
  return rays;
}

}  // namespace

struct HandMarch::Mesh {
  struct HullFace {
    glm::vec3 normal;  // outwards
    float offset;
    int a, b, c, tet;  // wound inwards
  };
  std::vector<float> vertices;  // rows: position, density, colour, 0
  std::vector<float> tets;      // rows, as bits: ids, neighbours
  std::vector<HullFace> hull;

  Corner FetchCorner(const Rays& rays, Ints id) const {
    Floats row[8];
    FetchRows(vertices.data(), id, row);
    const Floats r[3] = {row[0] - rays.origin[0], row[1] - rays.origin[1], row[2] - rays.origin[2]};
    Corner corner;
    corner.x = Dot(r, rays.u);
    corner.y = Dot(r, rays.v);
    corner.z = Dot(r, rays.direction);
    corner.x = corner.x == 0.0f && corner.y == 0.0f ? Floats{} + 1e-20f : corner.x;
    corner.density = row[3];
    for (int i = 0; i < 3; ++i) corner.color[i] = row[4 + i];
    corner.id = id;
    return corner;
  }

  // Moves the rays that hit the hull to it; returns their entry faces, -1 for rays that miss.
  Ints Enter(Rays& rays) const {
    Floats begin = Floats{} - 3e38f, end = Floats{} + 3e38f;
    for (const HullFace& face : hull) {
      const Floats along = face.normal.x * rays.direction[0] + face.normal.y * rays.direction[1] +
                           face.normal.z * rays.direction[2];
      const Floats t = (face.offset - face.normal.x * rays.origin[0] -
                        face.normal.y * rays.origin[1] - face.normal.z * rays.origin[2]) /
                       along;
      begin = along < 0.0f ? Max(begin, t) : begin;
      end = along > 0.0f ? Min(end, t) : end;
    }
    const Ints hit = begin <= end && begin >= 0.0f;
    Ints entry = Ints{} - 1;
    if (!Any(hit)) return entry;
    for (int i = 0; i < 3; ++i) {
      rays.origin[i] += (hit ? begin : Floats{}) * rays.direction[i];
    }
    Floats best = Floats{};
    for (int f = 0; f < int(hull.size()); ++f) {
      const HullFace& face = hull[size_t(f)];
      const Floats along = face.normal.x * rays.direction[0] + face.normal.y * rays.direction[1] +
                           face.normal.z * rays.direction[2];
      const Floats away = face.normal.x * rays.origin[0] + face.normal.y * rays.origin[1] +
                          face.normal.z * rays.origin[2] - face.offset;
      const Ints candidate = hit & (along < 0.0f) & (Abs(away) <= 4e-6f * end);
      if (!Any(candidate)) continue;
      const Corner a = FetchCorner(rays, Ints{} + face.a), b = FetchCorner(rays, Ints{} + face.b),
                   c = FetchCorner(rays, Ints{} + face.c);
      const Floats inside = Min(EdgeFunction(b, c), Min(EdgeFunction(c, a), EdgeFunction(a, b)));
      // The first face that contains the ray, or a later one that contains it more clearly.
      const Ints better = candidate & (inside >= 0.0f) & ((entry < 0) | (inside > best));
      best = better ? inside : best;
      entry = better ? Ints{} + f : entry;
    }
    return entry;
  }

  void March(Rays rays, float stop_depth, glm::vec4* colors) const {
    const Ints entry = Enter(rays);
    Ints go = entry >= 0;
    int32_t begin[4][kLanes];  // corners and tet
    for (int lane = 0; lane < kLanes; ++lane) {
      const HullFace& face = hull[size_t(std::max(0, int(entry[lane])))];
      begin[0][lane] = face.a, begin[1][lane] = face.b;
      begin[2][lane] = face.c, begin[3][lane] = face.tet;
    }
    Corner a = FetchCorner(rays, Load(begin[0])), b = FetchCorner(rays, Load(begin[1])),
           c = FetchCorner(rays, Load(begin[2]));
    Ints tet = Load(begin[3]);
    Floats ea = EdgeFunction(b, c), eb = EdgeFunction(c, a), ec = EdgeFunction(a, b);
    Floats color[3] = {}, depth = {}, z0 = {}, density0 = {}, color0[3] = {};
    bool first = true;
    while (Any(go)) {
      if (!first) {
        Floats row[8];
        FetchRows(tets.data(), go ? tet : Ints{}, row);
        const auto word = [&row](int i) { return Ints(row[i]); };
        const Ints apex = word(0) ^ word(1) ^ word(2) ^ word(3) ^ a.id ^ b.id ^ c.id;
        const Corner fresh = FetchCorner(rays, go ? apex : Ints{});
        const Floats sa = EdgeFunction(a, fresh), sb = EdgeFunction(b, fresh),
                     sc = EdgeFunction(c, fresh);
        const Floats without_a = Min(sc, -sb), without_b = Min(sa, -sc), without_c = Min(sb, -sa);
        const Ints c_leaves = without_c >= Max(without_a, without_b);
        const Ints b_leaves = ~c_leaves & (without_b >= without_a);
        const Ints a_leaves = ~(c_leaves | b_leaves);
        const Ints leaving = c_leaves ? c.id : b_leaves ? b.id : a.id;
        const Floats na = c_leaves ? sb : b_leaves ? -sc : ea;
        const Floats nb = c_leaves ? -sa : b_leaves ? eb : sc;
        const Floats nc = c_leaves ? ec : b_leaves ? sa : -sb;
        ea = na, eb = nb, ec = nc;
        Replace(a, a_leaves, fresh);
        Replace(b, b_leaves, fresh);
        Replace(c, c_leaves, fresh);
        tet = word(0) == leaving   ? word(4)
              : word(1) == leaving ? word(5)
              : word(2) == leaving ? word(6)
                                   : word(7);
      }
      const Floats zero = {};
      Floats wa = Max(ea, zero), wb = Max(eb, zero), wc = Max(ec, zero);
      const Floats sum = wa + wb + wc, scale = 1.0f / sum, third = zero + 1.0f / 3;
      wa = sum > 0.0f ? wa * scale : third;
      wb = sum > 0.0f ? wb * scale : third;
      wc = sum > 0.0f ? wc * scale : third;
      const Floats at_z = wa * a.z + wb * b.z + wc * c.z;
      const Floats density1 = wa * a.density + wb * b.density + wc * c.density;
      Floats color1[3];
      for (int i = 0; i < 3; ++i) {
        color1[i] = wa * a.color[i] + wb * b.color[i] + wc * c.color[i];
      }
      const Floats z1 = first ? at_z : Max(z0, at_z);
      if (!first) {
        const Floats s0 = go ? density0 * (z1 - z0) : zero, s1 = go ? density1 * (z1 - z0) : zero;
        const Ints thick = 0.5f * (s0 + s1) >= 2.5f;
        const SegmentWeights<F8> thin =
            IntegrateThinSegment(F8(thick ? zero : s0), F8(thick ? zero : s1));
        Floats w0 = thin.w0.v, w1 = thin.w1.v;
        if (Any(thick)) {
          for (int lane = 0; lane < kLanes; ++lane) {
            if (!thick[lane]) continue;
            const auto weights = IntegrateThickSegment(float(s0[lane]), float(s1[lane]));
            w0[lane] = weights.w0, w1[lane] = weights.w1;
          }
        }
        const Floats t = Exp(-depth);
        for (int i = 0; i < 3; ++i) {
          color[i] += go ? t * (w0 * color0[i] + w1 * color1[i]) : zero;
        }
        depth += 0.5f * (s0 + s1);
        go = go & (tet >= 0) & (depth < stop_depth);
      }
      z0 = z1;
      density0 = density1;
      for (int i = 0; i < 3; ++i) color0[i] = color1[i];
      first = false;
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      colors[lane] = {color[0][lane], color[1][lane], color[2][lane], depth[lane]};
    }
  }
};

HandMarch::HandMarch(const RadianceField& field) {
  auto built = std::make_unique<Mesh>();
  const TetMesh& mesh = field.mesh;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3 &p = mesh.positions[v], &c = field.color_srgb[v];
    built->vertices.insert(built->vertices.end(),
                           {p.x, p.y, p.z, field.density[v], c.r, c.g, c.b, 0.0f});
  }
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      built->tets.push_back(glm::uintBitsToFloat(mesh.tets[t][i]));
    }
    for (int i = 0; i < 4; ++i) {
      built->tets.push_back(glm::uintBitsToFloat(mesh.neighbors[t][i]));
      if (mesh.neighbors[t][i] != kNoTet) continue;
      const auto& corner = kFaceVertices[i];
      const uint32_t a = mesh.tets[t][corner[0]], b = mesh.tets[t][corner[1]],
                     c = mesh.tets[t][corner[2]];
      const glm::dvec3 pa(mesh.positions[a]), pb(mesh.positions[b]), pc(mesh.positions[c]);
      const glm::dvec3 normal = glm::normalize(glm::cross(pb - pa, pc - pa));
      built->hull.push_back(
          {glm::vec3(normal), float(glm::dot(normal, pa)), int(a), int(c), int(b), int(t)});
    }
  }
  mesh_ = std::move(built);
}

HandMarch::~HandMarch() = default;

bool HandMarch::CanRun() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }

std::vector<glm::vec4> HandMarch::MarchBlocks(const RenderView& view,
                                              std::span<const RayBlock> blocks,
                                              float stop_transmittance) const {
  std::vector<glm::vec4> colors(blocks.size() * kRaysPerBlock);
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const float stop_depth = -std::log(stop_transmittance);
  ParallelFor(blocks.size(), 64, [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      mesh_->March(MakeRays(view, world_from_cam, blocks[i]), stop_depth,
                   &colors[i * kRaysPerBlock]);
    }
  });
  return colors;
}

}  // namespace tetrec
