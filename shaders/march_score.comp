// Where the error is. Adds to every tet that a ray passes the ray's squared residual times the tet's
// share of the ray's opacity, and the transmittance that reaches it. The residual is what the loss
// kernel leaves in ray_gradients when its scale is 1/2.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "float_atomic.glsl"

#define Payload float
#define MakePayload(color) 0.0
#include "march.glsl"

layout(std430, binding = kBindRayStates) readonly buffer RayStates { uint ray_states[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindTetScores) buffer TetScores { AtomicFloat tet_scores[]; };

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  vec3 residual = ray_gradients[read].rgb;
  float error = dot(residual, residual);
  uint face = ray_states[read];
  bool inside = ray.start_tet != kNoTet;
  bool go = exists && ray.valid && (inside || face != kMiss);
  MarchState state;
  state.tet = kNoTet;
  if (go && inside) {
    state = EnterFromInside(ray, ray.start_tet);
  } else if (go) {
    MoveToHull(ray, HullInterval(ray));
    state = EnterThroughFace(ray, face);
  }

  float depth = 0.0;
  uint steps = 0u;
  vec3 w = HitWeights(state);
  float z0 = AtHit(w, state, p.z);
  float density0 = AtHit(w, state, density);
  while (go) {
    uint tet = state.tet;
    uvec4 ids = texelFetch(tets, int(2u * tet));
    uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
    StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
    w = HitWeights(state);
    float z1 = max(z0, AtHit(w, state, p.z));
    float density1 = AtHit(w, state, density);
    float behind = (inside && z0 < 0.0) ? (z1 > 0.0 ? -z0 / (z1 - z0) : 1.0) : 0.0;
    float length_in_tet = (1.0 - behind) * (z1 - z0);
    float tau = 0.5 * (mix(density0, density1, behind) + density1) * length_in_tet;
    float t = exp(-depth);
    AddFloat(tet_scores[2u * tet], error * t * (1.0 - exp(-tau)));
    AddFloat(tet_scores[2u * tet + 1u], t);
    depth += tau;
    z0 = z1;
    density0 = density1;
    steps += 1u;
    go = state.tet != kNoTet && depth < push.stop_depth && steps < push.max_steps;
  }
}
