// Where error and light are. Adds to every tet that a ray passes the ray's error (push.score) times
// the tet's share of the ray's opacity, and that share itself where it is visible. The residual is
// what the loss kernel leaves in ray_gradients when its scale is 1/2.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

#define Payload float
#define MakePayload(color) 0.0
#include "march.glsl"

layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { Entry ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindTetScores) buffer TetScores { Sum tet_scores[]; };  // kScoresPerTet each

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.rays.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  g_first_color = ray.slot * push.row_count;
  vec3 residual = ray_gradients[read].rgb;
  float error = push.score == kScoreSquaredResidual ? dot(residual, residual)
                                                    : dot(abs(residual), vec3(1.0));
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
  while (go) {
    uint tet = state.tet;
    uvec4 ids = texelFetch(tets, int(2u * tet));
    uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
    StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
    vec3 w = HitWeights(state);
    float z1 = max(z0, AtHit(w, state, p.z));
    float density1 = AtHit(w, state, density);
    if (kCells) density0 = density1 = FetchCell(tet).a;
    SegmentCut cut = CutAtZero(density0, density1);
    float tau = 0.5 * (DensityOf(density0) + DensityOf(density1)) * (cut.end - cut.begin) * (z1 - z0);
    float t = exp(-depth);
    float share = t * (1.0 - exp(-tau));
    if (share > kLeastScoredShare) {
      AddTo(tet_scores[kScoresPerTet * tet], error * share, kScoreQuanta);
      if (share > kLeastVisibleShare) AddTo(tet_scores[kScoresPerTet * tet + 1u], share, kScoreQuanta);
    }
    depth += tau;
    z0 = z1;
    density0 = density1;
    steps += 1u;
    go = state.tet != kNoTet && depth < push.rays.stop_depth && steps < push.max_steps;
    if (kAnyBoundary != 0) {
      TETREC_RARELY(hit && MayEnter(entries) && state.tet == kNoTet && depth < push.rays.stop_depth &&
                    steps < push.max_steps) {
        go = EnterAgain(ray, entries, state, begin);
        if (go) {
          z0 = max(z0, begin.z);
          density0 = begin.density;
        }
      }
    }
  }
}
