// Forward pass: colour before the background and optical depth of every ray.
#version 460
#extension GL_GOOGLE_include_directive : require

#define Payload vec3
#define MakePayload(color) (color)
#include "march.glsl"

layout(std430, binding = kBindRayColors) writeonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayStates) writeonly buffer RayStates { uint ray_states[]; };

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.ray_count;
  Ray ray = MakeRay(exists ? index : 0u);
  bool go = exists && ray.valid;
  bool inside = ray.start_tet != kNoTet;
  uint face = kMiss;
  float hull_length = 0.0;
  MarchState state;
  state.tet = kNoTet;
  if (go && inside) {
    state = EnterFromInside(ray, ray.start_tet);
  } else if (go) {
    vec2 interval = HullInterval(ray);
    go = interval.x <= interval.y && interval.x >= 0.0;
    if (go) {
      hull_length = MoveToHull(ray, interval);
      // A few roundings of coordinates as large as the way to the far side of the hull.
      face = FindEntryFace(ray, 4e-6 * interval.y);
      go = face != kMiss;
      if (go) state = EnterThroughFace(ray, face);
    }
  }
  bool hit = go;

  vec3 color = vec3(0.0);
  float depth = 0.0;  // optical
  uint steps = 0u;
  vec3 w = HitWeights(state);
  float z0 = AtHit(w, state, p.z);
  float density0 = AtHit(w, state, density);
  vec3 color0 = AtHit(w, state, payload);
  while (go) {
    uvec4 ids = texelFetch(tets, int(2u * state.tet));
    uvec4 neighbors = texelFetch(tets, int(2u * state.tet + 1u));
    StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
    w = HitWeights(state);
    float z1 = max(z0, AtHit(w, state, p.z));
    float density1 = AtHit(w, state, density);
    vec3 color1 = AtHit(w, state, payload);
    // A camera inside the first tet: the segment begins at the camera.
    float behind = (inside && z0 < 0.0) ? (z1 > 0.0 ? -z0 / (z1 - z0) : 1.0) : 0.0;
    float near_density = mix(density0, density1, behind);
    float length_in_tet = (1.0 - behind) * (z1 - z0);
    float s0 = near_density * length_in_tet, s1 = density1 * length_in_tet;
    SegmentWeights segment = IntegrateSegment(s0, s1);
    color += exp(-depth) * (segment.w0 * mix(color0, color1, behind) + segment.w1 * color1);
    depth += 0.5 * (s0 + s1);
    z0 = z1;
    density0 = density1;
    color0 = color1;
    steps += 1u;
    go = state.tet != kNoTet && depth < push.stop_depth && steps < push.max_steps;
  }

  if (exists) {
    ray_colors[index] = vec4(color, depth);
    ray_states[index] = face;
  }
  // A ray that did not stop early must have come out of the mesh where the hull ends.
  bool stopped = depth >= push.stop_depth;
  bool lost = hit && !stopped &&
              (state.tet != kNoTet || (!inside && abs(z0 - hull_length) > 1e-3 * (hull_length + z0)));
  if (lost) atomicAdd(counters[kCounterLostRays], 1u);
#ifdef TETREC_COUNT_STEPS
  atomicAdd(counters[kCounterSteps], steps);
  if (hit) atomicAdd(counters[kCounterHitRays], 1u);
#endif
}
