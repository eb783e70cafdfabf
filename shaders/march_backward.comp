// Backward pass: walks every ray again, front to back, and adds its gradients to the vertices.
//
// With g = dL/dcolour and h = dL/dtransmittance of a ray, its part of the loss is
// S = sum_i T_i (w0 g.c0 + w1 g.c1)_i + h T_end, all scalars. What lies behind segment i is S minus
// the parts up to and with i; a density change in i scales it by d(-tau): -1/2 for s0 and s1 each.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "float_atomic.glsl"

vec3 g_color;

#define Payload float
#define MakePayload(color) dot(g_color, color)
#include "march.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayStates) readonly buffer RayStates { uint ray_states[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { AtomicFloat vertex_gradients[]; };

// Gradient of one vertex of the triangle, kept until the vertex leaves it: x the sum of colour
// weights (dL/dcolour is g times it), y dL/ddensity.
void Flush(uint id, vec2 gradient) {
  if (gradient.x != 0.0 || gradient.y != 0.0) {
    AddFloat(vertex_gradients[4u * id], g_color.r * gradient.x);
    AddFloat(vertex_gradients[4u * id + 1u], g_color.g * gradient.x);
    AddFloat(vertex_gradients[4u * id + 2u], g_color.b * gradient.x);
    AddFloat(vertex_gradients[4u * id + 3u], gradient.y);
  }
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  vec4 gradient = ray_gradients[read];
  vec4 result = ray_colors[read];
  uint face = ray_states[read];
  g_color = gradient.rgb;
  bool inside = ray.start_tet != kNoTet;
  bool go = exists && ray.valid && (inside || face != kMiss) && gradient != vec4(0.0);
  MarchState state;
  state.tet = kNoTet;
  if (go && inside) {
    state = EnterFromInside(ray, ray.start_tet);
  } else if (go) {
    MoveToHull(ray, HullInterval(ray));
    state = EnterThroughFace(ray, face);
  }
  bool hit = go;

  float behind_all = dot(g_color, result.rgb) + gradient.w * exp(-result.w);
  float depth = 0.0;
  uint steps = 0u;
  vec2 grad_a = vec2(0.0), grad_b = vec2(0.0), grad_c = vec2(0.0);
  vec3 w = HitWeights(state);
  float z0 = AtHit(w, state, p.z);
  float density0 = AtHit(w, state, density);
  float k0 = AtHit(w, state, payload);
  while (go) {
    uvec4 ids = texelFetch(tets, int(2u * state.tet));
    uvec4 neighbors = texelFetch(tets, int(2u * state.tet + 1u));
    vec3 w_entry = w;
    uvec3 corners = uvec3(state.a.id, state.b.id, state.c.id);
    uint leaving = StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
    w = HitWeights(state);
    float z1 = max(z0, AtHit(w, state, p.z));
    float density1 = AtHit(w, state, density);
    float k1 = AtHit(w, state, payload);
    float behind = (inside && z0 < 0.0) ? (z1 > 0.0 ? -z0 / (z1 - z0) : 1.0) : 0.0;
    float length_in_tet = (1.0 - behind) * (z1 - z0);
    float s0 = mix(density0, density1, behind) * length_in_tet, s1 = density1 * length_in_tet;
    SegmentAdjoint segment = IntegrateSegmentWithDerivatives(s0, s1);
    float t = exp(-depth);
    float near_k = mix(k0, k1, behind);
    behind_all -= t * (segment.w0 * near_k + segment.w1 * k1);
    vec2 near = vec2(t * segment.w0,
                     length_in_tet * (t * (segment.dw0_ds0 * near_k + segment.dw1_ds0 * k1) -
                                      0.5 * behind_all));
    vec2 far = vec2(t * segment.w1,
                    length_in_tet * (t * (segment.dw0_ds1 * near_k + segment.dw1_ds1 * k1) -
                                     0.5 * behind_all));
    vec2 at_entry = (1.0 - behind) * near, at_exit = far + behind * near;
    grad_a += w_entry.x * at_entry;
    grad_b += w_entry.y * at_entry;
    grad_c += w_entry.z * at_entry;
    vec2 done = leaving == 0u ? grad_a : leaving == 1u ? grad_b : grad_c;
    uint done_id = leaving == 0u ? corners.x : leaving == 1u ? corners.y : corners.z;
    Flush(done_id, done);
    grad_a = (leaving == 0u ? vec2(0.0) : grad_a) + w.x * at_exit;
    grad_b = (leaving == 1u ? vec2(0.0) : grad_b) + w.y * at_exit;
    grad_c = (leaving == 2u ? vec2(0.0) : grad_c) + w.z * at_exit;
    depth += 0.5 * (s0 + s1);
    z0 = z1;
    density0 = density1;
    k0 = k1;
    steps += 1u;
    go = state.tet != kNoTet && depth < push.stop_depth && steps < push.max_steps;
  }
  if (hit) {
    Flush(state.a.id, grad_a);
    Flush(state.b.id, grad_b);
    Flush(state.c.id, grad_c);
  }
}
