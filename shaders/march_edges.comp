// What the rays say of a vertex in the middle of each edge (EdgeSums): adds the slopes of half the
// squared residual by its colour and density, and their Gauss-Newton curvatures. The residual is
// what the loss kernel leaves in ray_gradients when its scale is 1/2. Densities are counted in
// 1 / radius of the mesh's ball, so that fixed-point sums have room for them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

#define Payload vec3
#define MakePayload(color) (color)
#include "march.glsl"
#include "shared/edge_hat.glsl.h"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { Entry ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindTetEdges) readonly buffer TetEdges { uint tet_edges[]; };
layout(std430, binding = kBindEdgeSums) buffer EdgeSumsOfEdges { Sum edge_sums[]; };

// The weights of a point on the triangle of the state, and `apex` on the tet's other vertex, in the
// order of the tet's vertices.
vec4 WeightsInTet(MarchState state, vec3 w, float apex, uvec4 ids) {
  vec4 weights = vec4(apex);
  weights = mix(weights, vec4(w.x), equal(ids, uvec4(state.a.id)));
  weights = mix(weights, vec4(w.y), equal(ids, uvec4(state.b.id)));
  return mix(weights, vec4(w.z), equal(ids, uvec4(state.c.id)));
}

// What a segment adds for a vertex whose hat function is 1 in all of it.
struct Share {
  vec4 slopes;      // by colour | density
  vec2 curvatures;  // likewise
};

void AddToEdge(uint tet, uint edge, float hat, Share share) {
  uint first = kEdgeSums * tet_edges[6u * tet + edge];
  vec4 slopes = hat * share.slopes;
  vec2 curvatures = hat * hat * share.curvatures;
  AddTo(edge_sums[first], slopes.x, kScoreQuanta);
  AddTo(edge_sums[first + 1u], slopes.y, kScoreQuanta);
  AddTo(edge_sums[first + 2u], slopes.z, kScoreQuanta);
  AddTo(edge_sums[first + 3u], slopes.w, kScoreQuanta);
  AddTo(edge_sums[first + 4u], curvatures.x, kScoreQuanta);
  AddTo(edge_sums[first + 5u], curvatures.y, kScoreQuanta);
}

// w0, w1: weights at the segment's ends.
void AddToEdges(uint tet, vec4 w0, vec4 w1, Share share) {
  AddToEdge(tet, 0u, MeanHat(w0.x, w0.y, w1.x, w1.y), share);
  AddToEdge(tet, 1u, MeanHat(w0.x, w0.z, w1.x, w1.z), share);
  AddToEdge(tet, 2u, MeanHat(w0.x, w0.w, w1.x, w1.w), share);
  AddToEdge(tet, 3u, MeanHat(w0.y, w0.z, w1.y, w1.z), share);
  AddToEdge(tet, 4u, MeanHat(w0.y, w0.w, w1.y, w1.w), share);
  AddToEdge(tet, 5u, MeanHat(w0.z, w0.w, w1.z, w1.w), share);
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.rays.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  g_first_color = ray.slot * push.row_count;
  vec3 residual = ray_gradients[read].rgb;
  vec4 result = ray_colors[read];
  vec3 behind = result.rgb + exp(-result.w) * push.background.rgb;  // shown from here on
  Entry entry = ray_entries[read];
  bool go = exists && ray.valid && (ray.start_tet != kNoTet || entry.x != kMiss);
  MarchState state;
  Begin begin;
  state.tet = kNoTet;
  BeginMarch(ray, entry, go, state, begin);
  bool hit = go;
  Entries entries;
  if (kAnyBoundary != 0) entries = EntriesFrom(ray, entry, state);

  float depth = 0.0;
  uint steps = 0u;
  float z0 = begin.z;
  float density0 = begin.density;
  vec3 color0 = begin.payload;
  vec3 w_entry = begin.w;
  float w_apex = begin.w_apex;
  while (go) {
    uint tet = state.tet;
    uvec4 ids = texelFetch(tets, int(2u * tet));
    uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
    vec4 w0 = WeightsInTet(state, w_entry, w_apex, ids);
    StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
    vec3 w = HitWeights(state);
    vec4 w1 = WeightsInTet(state, w, 0.0, ids);
    float z1 = max(z0, AtHit(w, state, p.z));
    float density1 = AtHit(w, state, density);
    vec3 color1 = AtHit(w, state, payload);
    SegmentCut cut = CutAtZero(density0, density1);
    float size = (cut.end - cut.begin) * (z1 - z0);
    float tau = 0.5 * (DensityOf(density0) + DensityOf(density1)) * size;
    vec3 color = mix(color0, color1, 0.5 * (cut.begin + cut.end));
    float t1 = exp(-depth - tau);
    float opacity = exp(-depth) - t1;
    behind -= opacity * color;
    if (opacity > kLeastScoredShare) {
      vec3 by_density = size / push.mesh_ball.w * (t1 * color - behind);
      Share share;
      share.slopes = vec4(opacity * residual, dot(residual, by_density));
      share.curvatures = vec2(opacity * opacity, dot(by_density, by_density));
      AddToEdges(tet, mix(w0, w1, cut.begin), mix(w0, w1, cut.end), share);
    }
    depth += tau;
    z0 = z1;
    density0 = density1;
    color0 = color1;
    w_entry = w;
    w_apex = 0.0;
    steps += 1u;
    go = state.tet != kNoTet && depth < push.rays.stop_depth && steps < push.max_steps;
    if (kAnyBoundary != 0) {
      TETREC_RARELY(hit && MayEnter(entries) && state.tet == kNoTet && depth < push.rays.stop_depth &&
                    steps < push.max_steps) {
        go = EnterAgain(ray, entries, state, begin);
        if (go) {
          z0 = max(z0, begin.z);
          density0 = begin.density;
          color0 = begin.payload;
          w_entry = begin.w;
        }
      }
    }
  }
}
