// Backward pass: walks every ray again, front to back, and adds its gradients to the vertices.
//
// With g = dL/dcolour and h = dL/dtransmittance of a ray, its part of the loss is
// S = sum_i T_i (w0 g.c0 + w1 g.c1)_i + h T_end, all scalars. What lies behind segment i is S minus
// the parts up to and with i; a density change in i scales it by d(-tau): -1/2 for s0 and s1 each.
//
// TETREC_POSITIONS: gradients by the vertices' positions too. A ray meets the face of corners p_j,
// weights w_j, at z, where density and colour are q. Across the ray z and q are linear functions on
// the face; moving p_j by m moves them along with weight w_j:
//   dq/dp_j = -w_j (dq/dx, dq/dy, 0), dz/dp_j = -w_j (dz/dx, dz/dy, -1),
// in the world's frame w_j [((g.d)/(n.d)) n - g] and w_j n/(n.d), g the slope of q in the face. A
// begin at a camera stays there: dz = 0, dq/dp_j = -w_j grad q.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

vec3 g_color;

#define Payload float
#define MakePayload(color) dot(g_color, color)
#include "march.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { Entry ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };

// Gradient of one vertex of the triangle, kept until the vertex leaves it: x the sum of colour
// weights (dL/dcolour is g times it), y dL/ddensity.
void Flush(uint id, vec2 gradient) {
  if (gradient.x != 0.0 || gradient.y != 0.0) {
    AddTo(vertex_gradients[4u * id], g_color.r * gradient.x, push.color_quanta);
    AddTo(vertex_gradients[4u * id + 1u], g_color.g * gradient.x, push.color_quanta);
    AddTo(vertex_gradients[4u * id + 2u], g_color.b * gradient.x, push.color_quanta);
    AddTo(vertex_gradients[4u * id + 3u], gradient.y, push.density_quanta);
  }
}

#ifdef TETREC_POSITIONS
layout(std430, binding = kBindPositionGradients) buffer PositionGradients {
  Sum position_gradients[];
};

mat3 world_from_ray;

// -dz/dp, -ddensity/dp, -dpayload/dp of the end of a segment by a corner of weight 1, ray's frame.
struct Slopes {
  vec3 z, density, payload;
};

// Of an end on the triangle of the state. None where the triangle is seen edge-on: below this share
// of its size squared, its area across the ray is rounding.
Slopes SlopesOnFace(MarchState state) {
  vec2 a = state.a.p.xy, b = state.b.p.xy, c = state.c.p.xy;
  float area = state.e.x + state.e.y + state.e.z;
  float size = dot(a, a) + dot(b, b) + dot(c, c);
  float scale = area > 1e-6 * size ? 1.0 / area : 0.0;
  vec3 by_x = scale * vec3(b.y - c.y, c.y - a.y, a.y - b.y);  // of the weights of a, b, c
  vec3 by_y = scale * vec3(c.x - b.x, a.x - c.x, b.x - a.x);
  vec3 z = vec3(state.a.p.z, state.b.p.z, state.c.p.z);
  vec3 density = vec3(state.a.density, state.b.density, state.c.density);
  vec3 payload = vec3(state.a.payload, state.b.payload, state.c.payload);
  Slopes slopes;
  slopes.z = vec3(dot(by_x, z), dot(by_y, z), -1.0);
  slopes.density = vec3(dot(by_x, density), dot(by_y, density), 0.0);
  slopes.payload = vec3(dot(by_x, payload), dot(by_y, payload), 0.0);
  return slopes;
}

// Of a begin at the camera inside the tet of the state and `apex`; none in a tet that is flat up to
// rounding.
Slopes SlopesInTet(MarchState state, Corner apex) {
  vec3 b = state.b.p - state.a.p, c = state.c.p - state.a.p, d = apex.p - state.a.p;
  float volume = dot(b, cross(c, d));
  bool is_flat = abs(volume) <= 1e-6 * length(b) * length(c) * length(d);
  float scale = is_flat ? 0.0 : 1.0 / volume;
  vec3 by_b = scale * cross(c, d), by_c = scale * cross(d, b), by_d = scale * cross(b, c);
  Slopes slopes;
  slopes.z = vec3(0.0);
  slopes.density = (state.b.density - state.a.density) * by_b +
                   (state.c.density - state.a.density) * by_c +
                   (apex.density - state.a.density) * by_d;
  slopes.payload = (state.b.payload - state.a.payload) * by_b +
                   (state.c.payload - state.a.payload) * by_c +
                   (apex.payload - state.a.payload) * by_d;
  return slopes;
}

// What moves the corners, from dL/d(z, density, payload) of the end of a segment.
vec3 MoveOf(Slopes slopes, vec3 end) {
  return -(end.x * slopes.z + end.y * slopes.density + end.z * slopes.payload);
}

void FlushMove(uint id, vec3 move) {
  if (move != vec3(0.0)) {
    vec3 in_world = world_from_ray * move;
    AddTo(position_gradients[4u * id], in_world.x, push.position_quanta);
    AddTo(position_gradients[4u * id + 1u], in_world.y, push.position_quanta);
    AddTo(position_gradients[4u * id + 2u], in_world.z, push.position_quanta);
    AddTo(position_gradients[4u * id + 3u], length(move.xy), push.position_quanta);
  }
}
#endif

// What a ray carries on its way.
struct Walk {
  float depth;       // optical, before the segment
  float behind_all;  // the part of the loss that lies behind
  vec2 grad_a, grad_b, grad_c;
#ifdef TETREC_POSITIONS
  vec3 move_a, move_b, move_c;
  vec3 end;  // dL/d(z, density, payload) of the last segment's end, which is the next one's begin
#endif
};

// A segment between the entry and the exit triangle of a tet.
struct Segment {
  float s0, s1, size;  // size: its length
  float k0, k1;        // g . colour at its ends
  uint leaving;        // corner of the entry triangle that the exit triangle lacks: 0 a, 1 b, 2 c
  uint leaving_id;
  vec3 w_entry, w_exit;  // barycentric weights on the corners before and after the step
  float w_apex;          // of the entry point on the new corner; not 0 only at a camera
#ifdef TETREC_POSITIONS
  float density0, density1;
  Slopes slopes;  // of the begin
#endif
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
#ifdef TETREC_POSITIONS
  float by_size = segment.density0 * (by_s0 - 0.5 * walk.behind_all) +
                  segment.density1 * (by_s1 - 0.5 * walk.behind_all);
  vec3 move = MoveOf(segment.slopes, walk.end + vec3(-by_size, at_entry.y, at_entry.x));
  walk.end = vec3(by_size, at_exit.y, at_exit.x);
  walk.move_a += segment.w_entry.x * move;
  walk.move_b += segment.w_entry.y * move;
  walk.move_c += segment.w_entry.z * move;
  move *= segment.w_apex;
  FlushMove(segment.leaving_id, a_leaves ? walk.move_a : b_leaves ? walk.move_b : walk.move_c);
  walk.move_a = a_leaves ? move : walk.move_a;
  walk.move_b = b_leaves ? move : walk.move_b;
  walk.move_c = a_leaves || b_leaves ? walk.move_c : move;
#endif
  walk.depth += 0.5 * (segment.s0 + segment.s1);
}

// Lets the corners of a triangle by which the ray leaves the mesh go.
void FlushTriangle(inout Walk walk, MarchState state, Segment segment) {
  Flush(state.a.id, walk.grad_a);
  Flush(state.b.id, walk.grad_b);
  Flush(state.c.id, walk.grad_c);
  walk.grad_a = walk.grad_b = walk.grad_c = vec2(0.0);
#ifdef TETREC_POSITIONS
  vec3 move = MoveOf(SlopesOnFace(state), walk.end);
  FlushMove(state.a.id, walk.move_a + segment.w_exit.x * move);
  FlushMove(state.b.id, walk.move_b + segment.w_exit.y * move);
  FlushMove(state.c.id, walk.move_c + segment.w_exit.z * move);
  walk.move_a = walk.move_b = walk.move_c = walk.end = vec3(0.0);
#endif
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
  Entries entries;
  if (kAnyBoundary != 0) entries = EntriesFrom(ray, entry, state);

  Walk walk;
  walk.depth = 0.0;
  walk.behind_all = dot(g_color, result.rgb) + gradient.w * exp(-result.w);
  walk.grad_a = walk.grad_b = walk.grad_c = vec2(0.0);
#ifdef TETREC_POSITIONS
  world_from_ray = mat3(ray.u, ray.v, ray.direction);
  walk.move_a = walk.move_b = walk.move_c = walk.end = vec3(0.0);
#endif
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
#ifdef TETREC_POSITIONS
      segment.slopes = SlopesOnFace(state);
      TETREC_RARELY(steps == 0u && ray.start_tet != kNoTet) {
        segment.slopes = SlopesInTet(state, FetchApex(ray, state, ids));
      }
#endif
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
#ifdef TETREC_POSITIONS
      segment.density0 = density0;
      segment.density1 = density1;
#endif
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
    if (kAnyBoundary != 0) {
      TETREC_RARELY(hit && MayEnter(entries) && state.tet == kNoTet && walk.depth < push.stop_depth &&
                    steps < push.max_steps) {
        FlushTriangle(walk, state, segment);
        go = EnterAgain(ray, entries, state, begin);
        if (go) {
          segment.w_exit = begin.w;
          segment.k1 = begin.payload;
          z0 = max(z0, begin.z);
          density0 = begin.density;
        }
      }
    }
  }
  if (hit) FlushTriangle(walk, state, segment);
}
