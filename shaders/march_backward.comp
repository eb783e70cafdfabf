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
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { Entry ray_entries[]; };
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

// What a ray carries on its way.
struct Walk {
  float depth;       // optical, before the segment
  float behind_all;  // the part of the loss that lies behind
  vec2 grad_a, grad_b, grad_c;
};

// A segment between the entry and the exit triangle of a tet.
struct Segment {
  float s0, s1, size;  // size: its length
  float k0, k1;        // g . colour at its ends
  uint leaving;        // corner of the entry triangle that the exit triangle lacks: 0 a, 1 b, 2 c
  uint leaving_id;
  vec3 w_entry, w_exit;  // barycentric weights on the corners before and after the step
  float w_apex;          // of the entry point on the new corner; not 0 only at a camera
};

// Adds the gradients of a segment to the corners and lets the leaving one go.
void Deposit(inout Walk walk, Segment segment, SegmentAdjoint adjoint) {
  float t = exp(-walk.depth);
  walk.behind_all -= t * (adjoint.w0 * segment.k0 + adjoint.w1 * segment.k1);
  float by_s0 = t * (adjoint.dw0_ds0 * segment.k0 + adjoint.dw1_ds0 * segment.k1);
  float by_s1 = t * (adjoint.dw0_ds1 * segment.k0 + adjoint.dw1_ds1 * segment.k1);
  vec2 at_entry = vec2(t * adjoint.w0, segment.size * (by_s0 - 0.5 * walk.behind_all));
  vec2 at_exit = vec2(t * adjoint.w1, segment.size * (by_s1 - 0.5 * walk.behind_all));
  walk.grad_a += segment.w_entry.x * at_entry;
  walk.grad_b += segment.w_entry.y * at_entry;
  walk.grad_c += segment.w_entry.z * at_entry;
  vec2 apex = segment.w_apex * at_entry;
  bool a_leaves = segment.leaving == 0u, b_leaves = segment.leaving == 1u;
  Flush(segment.leaving_id, a_leaves ? walk.grad_a : b_leaves ? walk.grad_b : walk.grad_c);
  walk.grad_a = (a_leaves ? apex : walk.grad_a) + segment.w_exit.x * at_exit;
  walk.grad_b = (b_leaves ? apex : walk.grad_b) + segment.w_exit.y * at_exit;
  walk.grad_c = (a_leaves || b_leaves ? walk.grad_c : apex) + segment.w_exit.z * at_exit;
  walk.depth += 0.5 * (segment.s0 + segment.s1);
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  vec4 gradient = ray_gradients[read];
  vec4 result = ray_colors[read];
  Entry entry = ray_entries[read];
  g_color = gradient.rgb;
  bool go = exists && ray.valid && (ray.start_tet != kNoTet || entry.x != kMiss) &&
            gradient != vec4(0.0);
  MarchState state;
  Begin begin;
  state.tet = kNoTet;
  BeginMarch(ray, entry, go, state, begin);
  bool hit = go;

  Walk walk;
  walk.depth = 0.0;
  walk.behind_all = dot(g_color, result.rgb) + gradient.w * exp(-result.w);
  walk.grad_a = walk.grad_b = walk.grad_c = vec2(0.0);
  uint steps = 0u;
  Segment segment;
  segment.w_exit = begin.w;
  segment.w_apex = begin.w_apex;
  segment.k1 = begin.payload;
  float z0 = begin.z;
  float density0 = begin.density;
  while (go) {
    // Thick segments are integrated outside the inner loop, which they would slow down for all.
    bool thick = false;
    while (go && !thick) {
      uvec4 ids = texelFetch(tets, int(2u * state.tet));
      uvec4 neighbors = texelFetch(tets, int(2u * state.tet + 1u));
      uvec3 corners = uvec3(state.a.id, state.b.id, state.c.id);
      segment.w_entry = segment.w_exit;
      segment.k0 = segment.k1;
      segment.leaving = StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
      segment.leaving_id = segment.leaving == 0u   ? corners.x
                           : segment.leaving == 1u ? corners.y
                                                   : corners.z;
      segment.w_exit = HitWeights(state);
      float z1 = max(z0, AtHit(segment.w_exit, state, p.z));
      float density1 = AtHit(segment.w_exit, state, density);
      segment.k1 = AtHit(segment.w_exit, state, payload);
      segment.size = z1 - z0;
      segment.s0 = density0 * segment.size;
      segment.s1 = density1 * segment.size;
      thick = IsThickSegment(kIntegral, segment.s0, segment.s1);
      if (!thick) {
        Deposit(walk, segment,
                IntegrateUnlessThickWithDerivatives(kIntegral, kSplits, segment.s0, segment.s1));
        segment.w_apex = 0.0;
      }
      z0 = z1;
      density0 = density1;
      steps += 1u;
      go = state.tet != kNoTet && walk.depth < push.stop_depth && steps < push.max_steps;
    }
    if (thick) {
      Deposit(walk, segment, IntegrateThickSegmentWithDerivatives(segment.s0, segment.s1));
      segment.w_apex = 0.0;
      go = go && walk.depth < push.stop_depth;
    }
  }
  if (hit) {
    Flush(state.a.id, walk.grad_a);
    Flush(state.b.id, walk.grad_b);
    Flush(state.c.id, walk.grad_c);
  }
}
