// Composites a stretch of sorted tets, front to back: colour before the background and optical depth
// of every ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#define MakePayload(color) (color)
#include "projection_rays.glsl"

layout(std430, binding = kBindRayColors) buffer RayColors { vec4 ray_colors[]; };
#ifdef TETREC_COUNT_STEPS
layout(std430, binding = kBindRayEntries) buffer RayEntries { uvec2 ray_entries[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

// The key of a face, the same from both of its tets; 0 on the hull, and if it is no farther from the
// camera than rounding. The tets of a whole ray form a chain from key 0 to key 0, so the keys of the
// faces where it leaves minus those where it enters add up to 0 (mod 2^32), in whatever order.
uint KeyOf(uint tet, uvec4 neighbors, bvec4 face, bool near) {
  uint neighbor = face.x ? neighbors.x : face.y ? neighbors.y : face.z ? neighbors.z : neighbors.w;
  return near || neighbor == kNoTet ? 0u : Hash(min(tet, neighbor)) ^ max(tet, neighbor);
}
#endif

void main() {
  TileRay tile_ray = FindTileRay(gl_GlobalInvocationID.x);
  Ray ray = MakeMovedRay(tile_ray.index);
  vec4 result = vec4(0.0);
  if (push.is_first == 0u) result = ray_colors[tile_ray.index];
  vec3 color = result.rgb;
  float depth = result.a;  // optical
#ifdef TETREC_COUNT_STEPS
  uint chain = 0u, passed = 0u, steps = 0u;
  if (push.is_first == 0u) {
    chain = ray_entries[tile_ray.index].x;
    passed = ray_entries[tile_ray.index].y;
  }
#endif
  uint i = tile_ray.range.x;
  bool go = tile_ray.exists && ray.valid && i < tile_ray.range.y && depth < push.rays.stop_depth;
  while (go) {
    uint tet = tet_of_item[i];
    TetCut cut = CutTet(ray, tet);
    TETREC_RARELY(cut.hit) {
      vec3 k0 = FetchVertexColor(cut.ids.x);
      vec3 k1 = FetchVertexColor(cut.ids.y);
      vec3 k2 = FetchVertexColor(cut.ids.z);
      vec3 k3 = FetchVertexColor(cut.ids.w);
      vec3 color0 = cut.w0.x * k0 + cut.w0.y * k1 + cut.w0.z * k2 + cut.w0.w * k3;
      vec3 color1 = cut.w1.x * k0 + cut.w1.y * k1 + cut.w1.z * k2 + cut.w1.w * k3;
      float density0 = dot(cut.w0, cut.density), density1 = dot(cut.w1, cut.density);
      UseCell(tet, density0, density1, color0, color1);
      SegmentCut part = CutAtZero(density0, density1);
      float size = (part.end - part.begin) * (cut.z1 - cut.z0);
      float s0 = DensityOf(density0) * size, s1 = DensityOf(density1) * size;
      SegmentWeights segment = SegmentWeights(0.0, 0.0);
      bool thick = IsThickSegment(kIntegral, s0, s1);
      if (!thick) segment = IntegrateUnlessThick(kIntegral, kSplits, s0, s1);
      TETREC_RARELY(thick) segment = IntegrateThickSegment(s0, s1);
      color += exp(-depth) * (segment.w0 * mix(color0, color1, part.begin) +
                             segment.w1 * mix(color0, color1, part.end));
      depth += 0.5 * (s0 + s1);
#ifdef TETREC_COUNT_STEPS
      uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
      float far = push.rounding - push.start;
      chain += KeyOf(tet, neighbors, cut.face1, cut.z1 <= far);
      chain -= KeyOf(tet, neighbors, cut.face0, cut.z0 <= far);
      steps += 1u;
#endif
    }
    i += 1u;
    go = i < tile_ray.range.y && depth < push.rays.stop_depth;
  }
  if (tile_ray.exists) {
    ray_colors[tile_ray.index] = vec4(color, depth);
#ifdef TETREC_COUNT_STEPS
    passed |= min(steps, 1u);
    ray_entries[tile_ray.index] = uvec2(chain, passed);
    atomicAdd(counters[kCounterSteps], steps);
    if (push.is_last != 0u) {
      atomicAdd(counters[kCounterHitRays], passed);
      if (chain != 0u && depth < push.rays.stop_depth) atomicAdd(counters[kCounterLostRays], 1u);
    }
#endif
  }
}
